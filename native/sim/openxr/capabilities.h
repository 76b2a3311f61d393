// The capabilities of a stream, given the values selected so far.
#pragma once

#include "sensor_models.h"

namespace ml2sim::xr {

/** Returns the modes of stream number `index` that match its configs. */
std::vector<Mode> modesWith(const StreamModel &stream, uint32_t index, uint32_t configCount,
                            const XrPixelSensorConfigBaseHeaderML *const *configs);

} // namespace ml2sim::xr
