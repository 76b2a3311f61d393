/** The frames of a pixel sensor, from the runtime's data. */
#pragma once

#include "../sources/frameset.h"
#include "pixel_sensor.h"

/**
 * Waits for the next frame and adds it to set. The runtime writes into a slot of the stream if it can, and otherwise
 * into spare memory, from which the frame is copied.
 */
ml2s_result pixel_frame_get(struct pixel_sensor *sensor, uint64_t timeout_nanos, struct frameset *set,
                            ml2s_error *error);
