// What a stream offers, given what was chosen so far.
#pragma once

#include "sensor_models.h"

namespace ml2sim::xr {

/** The modes of stream number `index` that agree with those of the configs that are for it. */
std::vector<Mode> modesWith(const StreamModel &stream, uint32_t index, uint32_t configCount,
                            const XrPixelSensorConfigBaseHeaderML *const *configs);

} // namespace ml2sim::xr
