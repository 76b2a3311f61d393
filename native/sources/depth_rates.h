/** Rates of the depth camera, which depend on the mains that the lights here run on. */
#pragma once

#include "../sdk/perception.h"

/** The vendor's name of a rate. */
ml2s_result depth_rate_of(uint32_t rate_hz, MLDepthCameraFrameRate *vendor, ml2s_error *error);

/** The rates that camera has here for a range, as far as there is room. */
ml2s_result depth_rates(MLHandle camera, MLDepthCameraFrameType type, uint32_t *rates_hz, uint32_t capacity,
                        uint32_t *count, ml2s_error *error);
