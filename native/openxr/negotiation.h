/** Finding out what one stream of a pixel sensor can do, and configuring it to exactly what is wanted. */
#pragma once

#include "xr_api.h"

struct pixel_mode {
    const char *path;       /**< Of the sensor, for messages. */
    uint32_t device_stream; /**< The sensor's own number. */
    uint32_t rate_hz;
    uint32_t width;
    uint32_t height;
    XrPixelSensorFrameTypeML format;
    XrPixelSensorRealityModeML reality; /**< Where the stream has a choice of it. */
};

/**
 * Configures the stream. ML2S_INVALID_ARGUMENT names the value that is not offered, given those before it (rate,
 * resolution, format, reality), and what is.
 */
ml2s_result negotiate(XrPixelSensorML sensor, const struct pixel_mode *mode, ml2s_error *error);
