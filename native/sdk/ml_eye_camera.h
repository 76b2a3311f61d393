/**
 * The vendor's eye cameras (API level 26), without pose and intrinsics. A get blocks; a handle is not thread-safe. The
 * system owns the frames; each successful get needs exactly one release.
 */
#pragma once

#include "ml_types.h"

typedef uint32_t MLEyeCameraIdentifier;
enum {
    MLEyeCameraIdentifier_None = 0,
    MLEyeCameraIdentifier_LeftTemple = 1u << 0,
    MLEyeCameraIdentifier_LeftNasal = 1u << 1,
    MLEyeCameraIdentifier_RightNasal = 1u << 2,
    MLEyeCameraIdentifier_RightTemple = 1u << 3,
    MLEyeCameraIdentifier_All = 15,
};

typedef struct MLEyeCameraSettings {
    uint32_t version;
    uint32_t cameras;
} MLEyeCameraSettings;

typedef struct MLEyeCameraFrameBuffer {
    uint32_t width, height;
    uint32_t stride; /**< Bytes. */
    uint32_t bytes_per_pixel;
    uint32_t pixel_stride; /**< Bytes. */
    uint32_t size;         /**< Bytes. */
    uint8_t *data;
} MLEyeCameraFrameBuffer;

typedef struct MLEyeCameraFrame {
    MLEyeCameraIdentifier camera_id;
    int64_t frame_number;
    MLTime timestamp;
    MLEyeCameraFrameBuffer frame_buffer;
} MLEyeCameraFrame;

typedef struct MLEyeCameraData {
    uint32_t version;
    uint8_t frame_count;
    MLEyeCameraFrame *frames;
} MLEyeCameraData;

static inline void MLEyeCameraSettingsInit(MLEyeCameraSettings *settings) {
    memset(settings, 0, sizeof *settings);
    settings->version = 1;
    settings->cameras = MLEyeCameraIdentifier_All;
}

static inline void MLEyeCameraDataInit(MLEyeCameraData *data) {
    memset(data, 0, sizeof *data);
    data->version = 1;
}

#define ML_EYE_CAMERA_FUNCTIONS(F)                                                                                     \
    F(MLEyeCameraConnect, (const MLEyeCameraSettings *settings, MLHandle *out_cameras))                                \
    F(MLEyeCameraUpdateSettings, (MLHandle cameras, const MLEyeCameraSettings *settings))                              \
    F(MLEyeCameraGetLatestCameraData, (MLHandle cameras, uint64_t timeout_ms, MLEyeCameraData * inout_data))           \
    F(MLEyeCameraReleaseCameraData, (MLHandle cameras, MLEyeCameraData * data))                                        \
    F(MLEyeCameraDisconnect, (MLHandle cameras))

ML_EYE_CAMERA_FUNCTIONS(ML_PROTOTYPE)

ML_SIZE(MLEyeCameraSettings, 8);
ML_SIZE(MLEyeCameraFrameBuffer, 32);
ML_OFFSET(MLEyeCameraFrameBuffer, data, 24);
ML_SIZE(MLEyeCameraFrame, 56);
ML_OFFSET(MLEyeCameraFrame, frame_buffer, 24);
ML_SIZE(MLEyeCameraData, 16);
ML_OFFSET(MLEyeCameraData, frames, 8);
