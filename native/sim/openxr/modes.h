// The modes of a stream, and their values.
#pragma once

#include "sensor_models.h"

namespace ml2sim::xr {

bool operator==(const XrExtent2Di &a, const XrExtent2Di &b);

/** Returns the value of a capability other than the resolution. */
uint32_t numberOf(const Mode &mode, XrPixelSensorCapabilityTypeML type);

/** Returns the modes of stream number `index` that match its configs. */
std::vector<Mode> modesWith(const StreamModel &stream, uint32_t index, uint32_t configCount,
                            const XrPixelSensorConfigBaseHeaderML *const *configs);

} // namespace ml2sim::xr
