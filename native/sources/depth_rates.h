/** Rates of the depth camera. They depend on the mains frequency of the lights. */
#pragma once

#include "../sdk/perception.h"

/** Converts a rate to the vendor's enumeration. */
ml2s_result depth_rate_of(uint32_t rate_hz, MLDepthCameraFrameRate *vendor, ml2s_error *error);

/** Returns the rates of camera for a range, up to capacity. */
ml2s_result depth_rates(MLHandle camera, MLDepthCameraFrameType type, uint32_t *rates_hz, uint32_t capacity,
                        uint32_t *count, ml2s_error *error);
