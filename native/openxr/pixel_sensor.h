/** One running stream of a pixel sensor. Belongs to the thread that started it. */
#pragma once

#include "negotiation.h"

struct pixel_sensor {
    uint32_t stream; /**< ml2s_stream */
    struct pixel_mode mode;
    uint32_t wants; /**< ML2S_WANT_* */
    XrPixelSensorML sensor;
    XrSpace space;
    uint32_t metadata;     /**< Types of metadata of a frame: a mask of 1 << XrPixelSensorMetadataTypeML. */
    uint32_t buffer_bytes; /**< Size that the runtime requires, for pixels and metadata. */
    ml2s_memory spare;     /**< The runtime writes here if it cannot use a slot. Mapped when first needed. */
    bool is_copied;        /**< Frames are copied, since pictures lie outside the buffer. */
    XrTime last_capture;
    int64_t frame_count; /**< Number of the last frame, from 1. The runtime gives no frame numbers. */
    bool is_running;
};

/**
 * Creates, configures and starts the stream that stream, mode and wants describe; the other fields of sensor are zero.
 * Returns ML2S_NOT_AVAILABLE with the name of a sensor that the device does not list. After a failure nothing is left.
 */
ml2s_result pixel_sensor_start(struct pixel_sensor *sensor, ml2s_error *error);

/** Stops the stream and destroys its objects, also if it returns a failure. */
ml2s_result pixel_sensor_stop(struct pixel_sensor *sensor, ml2s_error *error);
