/**
 * The vendor's world cameras (API level 23). A get blocks; a handle is not thread-safe. The system owns the frames;
 * each successful get needs exactly one release. A get returns at most one frame per camera and mode.
 */
#pragma once

#include "ml_types.h"

typedef uint32_t MLWorldCameraIdentifier;
enum {
    MLWorldCameraIdentifier_None = 0,
    MLWorldCameraIdentifier_Left = 1u << 0,
    MLWorldCameraIdentifier_Right = 1u << 1,
    MLWorldCameraIdentifier_Center = 1u << 2,
    MLWorldCameraIdentifier_All = 7,
};

enum {
    MLWorldCameraMode_Unknown = 0,
    MLWorldCameraMode_LowExposure = 1u << 0, /**< Only while the controller is tracked. */
    MLWorldCameraMode_NormalExposure = 1u << 1,
};

typedef uint32_t MLWorldCameraFrameType;
enum {
    MLWorldCameraFrameType_Unknown = 0,
    MLWorldCameraFrameType_LowExposure = 1,
    MLWorldCameraFrameType_NormalExposure = 2,
};

/** mode and cameras are masks. The system treats them as hints. */
typedef struct MLWorldCameraSettings {
    uint32_t version;
    uint32_t mode;
    uint32_t cameras;
} MLWorldCameraSettings;

typedef struct MLWorldCameraIntrinsics {
    uint32_t width, height;
    MLVec2f focal_length, principal_point;
    float fov;                       /**< Degrees. */
    double radial_distortion[4];     /**< k1 k2 k3 k4, equidistant; applied first. */
    double tangential_distortion[2]; /**< p1 p2 */
} MLWorldCameraIntrinsics;

typedef struct MLWorldCameraFrameBuffer {
    uint32_t width, height;
    uint32_t stride; /**< Bytes. */
    uint32_t bytes_per_pixel;
    uint32_t size; /**< Bytes. */
    uint8_t *data;
} MLWorldCameraFrameBuffer;

typedef struct MLWorldCameraFrame {
    MLWorldCameraIdentifier id;
    int64_t frame_number; /**< Counts per camera and mode; can restart at 0. */
    MLTime timestamp;
    MLWorldCameraIntrinsics intrinsics;
    MLTransform camera_pose;
    MLWorldCameraFrameBuffer frame_buffer;
    MLWorldCameraFrameType frame_type;
} MLWorldCameraFrame;

typedef struct MLWorldCameraData {
    uint32_t version;
    uint8_t frame_count;
    MLWorldCameraFrame *frames;
} MLWorldCameraData;

static inline void MLWorldCameraSettingsInit(MLWorldCameraSettings *settings) {
    memset(settings, 0, sizeof *settings);
    settings->version = 1;
    settings->mode = MLWorldCameraMode_NormalExposure;
    settings->cameras = MLWorldCameraIdentifier_All;
}

static inline void MLWorldCameraDataInit(MLWorldCameraData *data) {
    memset(data, 0, sizeof *data);
    data->version = 1;
}

/** *inout_data must point to an initialised structure of the caller, which the get fills. */
#define ML_WORLD_CAMERA_FUNCTIONS(F)                                                                                   \
    F(MLWorldCameraConnect, (const MLWorldCameraSettings *settings, MLHandle *out_cameras))                            \
    F(MLWorldCameraUpdateSettings, (MLHandle cameras, const MLWorldCameraSettings *settings))                          \
    F(MLWorldCameraGetLatestWorldCameraData, (MLHandle cameras, uint64_t timeout_ms, MLWorldCameraData * *inout_data)) \
    F(MLWorldCameraReleaseCameraData, (MLHandle cameras, MLWorldCameraData * data))                                    \
    F(MLWorldCameraDisconnect, (MLHandle cameras))

ML_WORLD_CAMERA_FUNCTIONS(ML_PROTOTYPE)

ML_SIZE(MLWorldCameraSettings, 12);
ML_SIZE(MLWorldCameraIntrinsics, 80);
ML_OFFSET(MLWorldCameraIntrinsics, radial_distortion, 32);
ML_OFFSET(MLWorldCameraIntrinsics, tangential_distortion, 64);
ML_SIZE(MLWorldCameraFrameBuffer, 32);
ML_OFFSET(MLWorldCameraFrameBuffer, data, 24);
ML_SIZE(MLWorldCameraFrame, 176);
ML_OFFSET(MLWorldCameraFrame, frame_number, 8);
ML_OFFSET(MLWorldCameraFrame, timestamp, 16);
ML_OFFSET(MLWorldCameraFrame, intrinsics, 24);
ML_OFFSET(MLWorldCameraFrame, camera_pose, 104);
ML_OFFSET(MLWorldCameraFrame, frame_buffer, 136);
ML_OFFSET(MLWorldCameraFrame, frame_type, 168);
ML_SIZE(MLWorldCameraData, 16);
ML_OFFSET(MLWorldCameraData, frames, 8);
