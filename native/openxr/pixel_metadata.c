#include "pixel_metadata.h"

#include <string.h>

#include "../sources/conversions.h"

static bool has(uint32_t types, XrPixelSensorMetadataTypeML type) { return types & 1u << type; }

void pixel_metadata_chain(struct pixel_metadata *metadata, uint32_t types, XrPixelSensorDataML *data) {
    *metadata = (struct pixel_metadata){
        .exposure.type = XR_TYPE_PIXEL_SENSOR_EXPOSURE_TIME_ML,
        .analog_gain.type = XR_TYPE_PIXEL_SENSOR_ANALOG_GAIN_ML,
        .digital_gain.type = XR_TYPE_PIXEL_SENSOR_DIGITAL_GAIN_ML,
        .pinhole.type = XR_TYPE_PIXEL_SENSOR_PINHOLE_INTRINSICS_ML,
        .fisheye.type = XR_TYPE_PIXEL_SENSOR_FISHEYE_INTRINSICS_ML,
        .illumination.type = XR_TYPE_PIXEL_SENSOR_DEPTH_FRAME_ILLUMINATION_ML,
        .confidence.type = XR_TYPE_PIXEL_SENSOR_DEPTH_CONFIDENCE_BUFFER_ML,
        .flags.type = XR_TYPE_PIXEL_SENSOR_DEPTH_FLAG_BUFFER_ML,
    };
    void *const structures[XR_PIXEL_SENSOR_METADATA_COUNT_ML] = {
        [XR_PIXEL_SENSOR_METADATA_EXPOSURE_TIME_ML] = &metadata->exposure,
        [XR_PIXEL_SENSOR_METADATA_ANALOG_GAIN_ML] = &metadata->analog_gain,
        [XR_PIXEL_SENSOR_METADATA_DIGITAL_GAIN_ML] = &metadata->digital_gain,
        [XR_PIXEL_SENSOR_METADATA_PINHOLE_ML] = &metadata->pinhole,
        [XR_PIXEL_SENSOR_METADATA_FISHEYE_ML] = &metadata->fisheye,
        [XR_PIXEL_SENSOR_METADATA_ILLUMINATION_ML] = &metadata->illumination,
        [XR_PIXEL_SENSOR_METADATA_CONFIDENCE_ML] = &metadata->confidence,
        [XR_PIXEL_SENSOR_METADATA_FLAGS_ML] = &metadata->flags,
    };
    for (uint32_t type = 0; type < XR_PIXEL_SENSOR_METADATA_COUNT_ML; type++) {
        if (has(types, type)) {
            ((XrBaseOutStructure *)structures[type])->next = data->next;
            data->next = structures[type];
        }
    }
}

static void read_pinhole(const XrPixelSensorPinholeIntrinsicsML *pinhole, ml2s_frame *frame) {
    frame->lens = ML2S_LENS_PLUMB_BOB;
    frame->focal_length[0] = pinhole->focalLength.x;
    frame->focal_length[1] = pinhole->focalLength.y;
    frame->principal_point[0] = pinhole->principalPoint.x;
    frame->principal_point[1] = pinhole->principalPoint.y;
    memcpy(frame->distortion, pinhole->distortion, sizeof pinhole->distortion);
    frame->has |= is_lens(frame) ? ML2S_HAS_INTRINSICS : 0;
}

static void read_fisheye(const XrPixelSensorFisheyeIntrinsicsML *fisheye, ml2s_frame *frame) {
    frame->lens = ML2S_LENS_FISHEYE_TANGENTIAL;
    frame->focal_length[0] = fisheye->focalLength.x;
    frame->focal_length[1] = fisheye->focalLength.y;
    frame->principal_point[0] = fisheye->principalPoint.x;
    frame->principal_point[1] = fisheye->principalPoint.y;
    memcpy(frame->distortion, fisheye->radialDistortion, 4 * sizeof(double));
    memcpy(frame->distortion + 4, fisheye->tangentialDistortion, 2 * sizeof(double));
    frame->has |= is_lens(frame) ? ML2S_HAS_INTRINSICS : 0;
}

void pixel_metadata_read(const struct pixel_metadata *metadata, uint32_t types, ml2s_frame *frame) {
    // In milliseconds; no exposure is longer than a minute, and a value that is not a number is none
    if (has(types, XR_PIXEL_SENSOR_METADATA_EXPOSURE_TIME_ML) && metadata->exposure.exposureTime >= 0 &&
        metadata->exposure.exposureTime <= 60000) {
        frame->has |= ML2S_HAS_EXPOSURE;
        frame->exposure_nanos = (int64_t)((double)metadata->exposure.exposureTime * 1e6 + 0.5);
    }
    if (has(types, XR_PIXEL_SENSOR_METADATA_ANALOG_GAIN_ML)) {
        frame->has |= ML2S_HAS_ANALOG_GAIN;
        frame->analog_gain = metadata->analog_gain.gain;
    }
    if (has(types, XR_PIXEL_SENSOR_METADATA_DIGITAL_GAIN_ML)) {
        frame->has |= ML2S_HAS_DIGITAL_GAIN;
        frame->digital_gain = metadata->digital_gain.gain;
    }
    if (has(types, XR_PIXEL_SENSOR_METADATA_PINHOLE_ML)) {
        read_pinhole(&metadata->pinhole, frame);
    }
    if (has(types, XR_PIXEL_SENSOR_METADATA_FISHEYE_ML)) {
        read_fisheye(&metadata->fisheye, frame);
    }
    if (has(types, XR_PIXEL_SENSOR_METADATA_ILLUMINATION_ML)) {
        frame->has |= ML2S_HAS_ILLUMINATION;
        frame->illumination = metadata->illumination.illumination == XR_PIXEL_SENSOR_ILLUMINATION_ON_ML;
    }
}
