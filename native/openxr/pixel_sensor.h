/** One running stream of a pixel sensor. Belongs to the thread that started it. */
#pragma once

#include "../sources/frameset.h"
#include "negotiation.h"

struct pixel_sensor {
    uint32_t stream; /**< ml2s_stream */
    struct pixel_mode mode;
    uint32_t wants; /**< ML2S_WANT_* */
    XrPixelSensorML sensor;
    XrSpace space;
    uint32_t metadata;     /**< Types that come with its frames: a mask of 1 << XrPixelSensorMetadataTypeML. */
    uint32_t buffer_bytes; /**< As the runtime wants it: pixels, and whatever it keeps beside them. */
    ml2s_memory spare;     /**< Where the runtime writes when it cannot into a slot; mapped when first needed. */
    bool is_copied;        /**< Slots are not written by the runtime: too small, or its pictures lie elsewhere. */
    XrTime last_capture;
    int64_t frame_count; /**< Their frame numbers, from 1: the runtime gives none. */
    bool is_running;
};

/**
 * Creates, configures and starts the stream that stream, mode and wants of sensor say; the rest of it is zero.
 * ML2S_NOT_AVAILABLE names a sensor that the device does not list. A failure leaves nothing.
 */
ml2s_result pixel_sensor_start(struct pixel_sensor *sensor, ml2s_error *error);

/** Ends everything, whatever it answers. */
ml2s_result pixel_sensor_stop(struct pixel_sensor *sensor, ml2s_error *error);

/**
 * Waits for the first frame after the last one, and adds it to set. The runtime writes into a slot of the stream, and
 * that is the frame's. Where it cannot, it writes into spare memory, from which the frame is copied.
 */
ml2s_result pixel_sensor_get(struct pixel_sensor *sensor, uint64_t timeout_nanos, struct frameset *set,
                             ml2s_error *error);
