/** From what the runtime has written into a slot to the frame that describes it. */
#pragma once

#include "pixel_metadata.h"
#include "pixel_sensor.h"

/**
 * Describes the data in memory, in place; depth is made z along the optical axis, or NaN, unless the radial distance is
 * wanted. ML2S_VENDOR_FAILURE when a picture does not lie in memory as its description says. The slot is left alone.
 */
ml2s_result pixel_frame_read(const struct pixel_sensor *sensor, const XrPixelSensorDataML *data,
                             const struct pixel_metadata *metadata, const ml2s_memory *memory, ml2s_frame *frame,
                             ml2s_error *error);

/** Without slot, data and planes. */
void pixel_frame_lose(ml2s_frame *frame);
