/** From what the runtime has written to the frame that describes it. */
#pragma once

#include "pixel_metadata.h"
#include "pixel_sensor.h"

/**
 * Describes the data. Where all pictures lie in memory, which is that of slot, the frame is in that slot; else they are
 * copied into another one, and the frame is lost without a free one. Depth is made z along the optical axis, or NaN,
 * unless the radial distance is wanted. ML2S_VENDOR_FAILURE when a picture is not as the mode and its own description
 * say; then the frame has no slot.
 *
 * @param slot ML2S_NO_SLOT when memory is none; the frame may share its lease.
 */
ml2s_result pixel_frame_read(struct pixel_sensor *sensor, const XrPixelSensorDataML *data,
                             const struct pixel_metadata *metadata, uint32_t slot, const ml2s_memory *memory,
                             ml2s_frame *frame, ml2s_error *error);
