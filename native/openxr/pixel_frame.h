/** Conversion of the runtime's data to frames. */
#pragma once

#include "pixel_metadata.h"
#include "pixel_sensor.h"

/**
 * Fills frame from data. If all pictures lie in memory, which is that of slot, the frame uses that slot. Otherwise they
 * are copied into another slot; if none is free, the frame is lost. Depth is converted to z along the optical axis, or
 * NaN, unless the settings ask for the radial distance. Returns ML2S_VENDOR_FAILURE, and a frame without slot, if a
 * picture does not match the mode or its own description.
 *
 * @param slot ML2S_NO_SLOT if memory is no slot. The frame can share the lease of the caller.
 */
ml2s_result pixel_frame_read(struct pixel_sensor *sensor, const XrPixelSensorDataML *data,
                             const struct pixel_metadata *metadata, uint32_t slot, const ml2s_memory *memory,
                             ml2s_frame *frame, ml2s_error *error);
