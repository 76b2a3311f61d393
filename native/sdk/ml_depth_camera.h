/**
 * The vendor's depth camera (API level 29), with one stream at a time. A get blocks; a handle is not thread-safe. The
 * system owns the frames; each successful get needs exactly one release.
 */
#pragma once

#include "ml_types.h"

typedef uint32_t MLDepthCameraStream;
enum {
    MLDepthCameraStream_None = 0,
    MLDepthCameraStream_LongRange = 1u << 0,
    MLDepthCameraStream_ShortRange = 1u << 1,
};

/** Also the index into MLDepthCameraSettings.stream_configs. */
typedef uint32_t MLDepthCameraFrameType;
enum {
    MLDepthCameraFrameType_LongRange = 0,
    MLDepthCameraFrameType_ShortRange = 1,
    MLDepthCameraFrameType_Count = 2,
};

/** An enumeration, not Hz. */
typedef uint32_t MLDepthCameraFrameRate;
enum {
    MLDepthCameraFrameRate_1FPS = 0,
    MLDepthCameraFrameRate_5FPS = 1,
    MLDepthCameraFrameRate_25FPS = 2,
    MLDepthCameraFrameRate_30FPS = 3,
    MLDepthCameraFrameRate_50FPS = 4,
    MLDepthCameraFrameRate_60FPS = 5,
};

/** The buffers to deliver. */
enum {
    MLDepthCameraFlags_DepthImage = 1u << 0,
    MLDepthCameraFlags_Confidence = 1u << 1,
    MLDepthCameraFlags_DepthFlags = 1u << 2,
    MLDepthCameraFlags_AmbientRawDepthImage = 1u << 3, /**< Light off. */
    MLDepthCameraFlags_RawDepthImage = 1u << 4,        /**< Light on. */
};

/** Flags of a pixel. OpenXR uses other bits. */
enum {
    MLDepthCameraDepthFlags_Valid = 0,
    MLDepthCameraDepthFlags_Invalid = 1u << 0, /**< Set with each of the other flags. */
    MLDepthCameraDepthFlags_Saturated = 1u << 1,
    MLDepthCameraDepthFlags_Inconsistent = 1u << 2,
    MLDepthCameraDepthFlags_LowSignal = 1u << 3,
    MLDepthCameraDepthFlags_FlyingPixel = 1u << 4,
    MLDepthCameraDepthFlags_Masked = 1u << 5,
    MLDepthCameraDepthFlags_SBI = 1u << 8,
    MLDepthCameraDepthFlags_StrayLight = 1u << 9,
    MLDepthCameraDepthFlags_ConnectedComponent = 1u << 10,
};

typedef struct MLDepthCameraStreamConfig {
    uint32_t flags;
    uint32_t exposure; /**< Microseconds: 250 to 2000 long range, 50 to 375 short range. */
    MLDepthCameraFrameRate frame_rate;
} MLDepthCameraStreamConfig;

typedef struct MLDepthCameraSettings {
    uint32_t version;
    uint32_t streams;
    MLDepthCameraStreamConfig stream_configs[MLDepthCameraFrameType_Count];
} MLDepthCameraSettings;

typedef struct MLDepthCameraIntrinsics {
    uint32_t width, height;
    MLVec2f focal_length, principal_point;
    float fov;            /**< Degrees. */
    double distortion[5]; /**< k1 k2 p1 p2 k3, plumb bob. */
} MLDepthCameraIntrinsics;

/** Pixels are float32, those of flags uint32. Depth is the distance from the camera in metres, not z. */
typedef struct MLDepthCameraFrameBuffer {
    uint32_t width, height;
    uint32_t stride; /**< Bytes. */
    uint32_t bytes_per_unit;
    uint32_t size; /**< Bytes. */
    void *data;
} MLDepthCameraFrameBuffer;

/** Buffers that the settings do not request are null. */
typedef struct MLDepthCameraFrame {
    int64_t frame_number;
    MLTime frame_timestamp;
    MLDepthCameraFrameType frame_type;
    MLTransform camera_pose;
    MLDepthCameraIntrinsics intrinsics;
    MLDepthCameraFrameBuffer *depth_image;
    MLDepthCameraFrameBuffer *confidence;
    MLDepthCameraFrameBuffer *flags;
    MLDepthCameraFrameBuffer *ambient_raw_depth_image;
    MLDepthCameraFrameBuffer *raw_depth_image;
} MLDepthCameraFrame;

typedef struct MLDepthCameraData {
    uint32_t version;
    uint8_t frame_count;
    MLDepthCameraFrame *frames;
} MLDepthCameraData;

typedef struct MLDepthCameraStreamCapability {
    MLDepthCameraStream stream;
    uint32_t min_exposure, max_exposure; /**< Microseconds. */
    MLDepthCameraFrameRate frame_rate;
} MLDepthCameraStreamCapability;

typedef struct MLDepthCameraCapability {
    uint8_t size;
    MLDepthCameraStreamCapability *stream_capabilities;
} MLDepthCameraCapability;

typedef struct MLDepthCameraCapabilityList {
    uint8_t size;
    MLDepthCameraCapability *capabilities;
} MLDepthCameraCapabilityList;

typedef struct MLDepthCameraCapabilityFilter {
    uint32_t version;
    uint32_t streams;
} MLDepthCameraCapabilityFilter;

static inline void MLDepthCameraSettingsInit(MLDepthCameraSettings *settings) {
    memset(settings, 0, sizeof *settings);
    settings->version = 2;
    settings->streams = MLDepthCameraStream_LongRange;
    for (int type = 0; type < MLDepthCameraFrameType_Count; type++) {
        settings->stream_configs[type].flags = MLDepthCameraFlags_DepthImage;
        settings->stream_configs[type].frame_rate = MLDepthCameraFrameRate_5FPS;
    }
    settings->stream_configs[MLDepthCameraFrameType_LongRange].exposure = 1600;
    settings->stream_configs[MLDepthCameraFrameType_ShortRange].exposure = 375;
}

static inline void MLDepthCameraDataInit(MLDepthCameraData *data) {
    memset(data, 0, sizeof *data);
    data->version = 3;
}

static inline void MLDepthCameraCapabilityFilterInit(MLDepthCameraCapabilityFilter *filter) {
    memset(filter, 0, sizeof *filter);
    filter->version = 1;
}

#define ML_DEPTH_CAMERA_FUNCTIONS(F)                                                                                   \
    F(MLDepthCameraConnect, (const MLDepthCameraSettings *settings, MLHandle *out_camera))                             \
    F(MLDepthCameraUpdateSettings, (MLHandle camera, const MLDepthCameraSettings *settings))                           \
    F(MLDepthCameraGetLatestDepthData, (MLHandle camera, uint64_t timeout_ms, MLDepthCameraData * inout_data))         \
    F(MLDepthCameraReleaseDepthData, (MLHandle camera, MLDepthCameraData * data))                                      \
    F(MLDepthCameraDisconnect, (MLHandle camera))

/** Each list is released exactly once. */
#define ML_DEPTH_CAMERA_CAPABILITIES_FUNCTIONS(F)                                                                      \
    F(MLDepthCameraGetCapabilities,                                                                                    \
      (MLHandle camera, const MLDepthCameraCapabilityFilter *filter, MLDepthCameraCapabilityList *out_list))           \
    F(MLDepthCameraReleaseCapabilities, (MLHandle camera, MLDepthCameraCapabilityList * list))

ML_DEPTH_CAMERA_FUNCTIONS(ML_PROTOTYPE)
ML_DEPTH_CAMERA_CAPABILITIES_FUNCTIONS(ML_PROTOTYPE)

ML_SIZE(MLDepthCameraStreamConfig, 12);
ML_SIZE(MLDepthCameraSettings, 32);
ML_OFFSET(MLDepthCameraSettings, stream_configs, 8);
ML_SIZE(MLDepthCameraIntrinsics, 72);
ML_OFFSET(MLDepthCameraIntrinsics, fov, 24);
ML_OFFSET(MLDepthCameraIntrinsics, distortion, 32);
ML_SIZE(MLDepthCameraFrameBuffer, 32);
ML_OFFSET(MLDepthCameraFrameBuffer, data, 24);
ML_SIZE(MLDepthCameraFrame, 160);
ML_OFFSET(MLDepthCameraFrame, frame_type, 16);
ML_OFFSET(MLDepthCameraFrame, camera_pose, 20);
ML_OFFSET(MLDepthCameraFrame, intrinsics, 48);
ML_OFFSET(MLDepthCameraFrame, depth_image, 120);
ML_OFFSET(MLDepthCameraFrame, confidence, 128);
ML_OFFSET(MLDepthCameraFrame, flags, 136);
ML_OFFSET(MLDepthCameraFrame, ambient_raw_depth_image, 144);
ML_OFFSET(MLDepthCameraFrame, raw_depth_image, 152);
ML_SIZE(MLDepthCameraData, 16);
ML_OFFSET(MLDepthCameraData, frame_count, 4);
ML_OFFSET(MLDepthCameraData, frames, 8);
ML_SIZE(MLDepthCameraStreamCapability, 16);
ML_SIZE(MLDepthCameraCapability, 16);
ML_SIZE(MLDepthCameraCapabilityFilter, 8);
