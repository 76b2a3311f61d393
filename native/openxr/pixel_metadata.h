/** The metadata of a frame. */
#pragma once

#include "xr_api.h"

/** One structure for each XrPixelSensorMetadataTypeML, chained to the data of one call. */
struct pixel_metadata {
    XrPixelSensorExposureTimeML exposure;
    XrPixelSensorAnalogGainML analog_gain;
    XrPixelSensorDigitalGainML digital_gain;
    XrPixelSensorPinholeIntrinsicsML pinhole;
    XrPixelSensorFisheyeIntrinsicsML fisheye;
    XrPixelSensorDepthFrameIlluminationML illumination;
    XrPixelSensorDepthConfidenceBufferML confidence;
    XrPixelSensorDepthFlagBufferML flags;
};

/** Clears metadata and chains the types (a mask of 1 << XrPixelSensorMetadataTypeML) to data. */
void pixel_metadata_chain(struct pixel_metadata *metadata, uint32_t types, XrPixelSensorDataML *data);

/** Sets exposure, gains, intrinsics and illumination of frame if types has them. */
void pixel_metadata_read(const struct pixel_metadata *metadata, uint32_t types, ml2s_frame *frame);
