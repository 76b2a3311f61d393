/** Configuration of a stream of a pixel sensor, checked against its capabilities. */
#pragma once

#include "xr_api.h"

struct pixel_mode {
    const char *path;       /**< The path of the sensor, for messages. */
    uint32_t device_stream; /**< The sensor's own number. */
    uint32_t rate_hz;
    uint32_t width;
    uint32_t height;
    XrPixelSensorFrameTypeML format;
    XrPixelSensorRealityModeML reality; /**< Used if the stream offers a choice. */
};

/**
 * Configures the stream, in the order rate, resolution, format, reality. Returns ML2S_INVALID_ARGUMENT with the first
 * value that is not offered with the values before it, and the values that are offered.
 */
ml2s_result negotiate(XrPixelSensorML sensor, const struct pixel_mode *mode, ml2s_error *error);
