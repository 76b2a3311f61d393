/**
 * The vendor's eye tracker (API level 26). Snapshots hold the poses of its coordinate frames. An eye looks along -z.
 */
#pragma once

#include "ml_types.h"

/** Coordinate frames: the point where the gaze rays meet, and the centre of each eye, rotated to its gaze. */
typedef struct MLEyeTrackingStaticData {
    MLCoordinateFrameUID vergence;
    MLCoordinateFrameUID left_center, right_center;
} MLEyeTrackingStaticData;

/** Confidences are 0 to 1. A value with confidence 0 is not valid. */
typedef struct MLEyeTrackingStateEx {
    uint32_t version;
    float vergence_confidence, left_center_confidence, right_center_confidence;
    bool left_blink, right_blink;
    uint32_t error; /**< 0: no error. */
    MLTime timestamp;
    float left_eye_openness, right_eye_openness; /**< 0 to 1. */
} MLEyeTrackingStateEx;

static inline void MLEyeTrackingStateInit(MLEyeTrackingStateEx *state) {
    memset(state, 0, sizeof *state);
    state->version = 2;
}

#define ML_EYE_TRACKING_FUNCTIONS(F)                                                                                   \
    F(MLEyeTrackingCreate, (MLHandle * out_tracker))                                                                   \
    F(MLEyeTrackingDestroy, (MLHandle tracker))                                                                        \
    F(MLEyeTrackingGetStaticData, (MLHandle tracker, MLEyeTrackingStaticData * out_data))                              \
    F(MLEyeTrackingGetStateEx, (MLHandle tracker, MLEyeTrackingStateEx * inout_state))

ML_EYE_TRACKING_FUNCTIONS(ML_PROTOTYPE)

ML_SIZE(MLEyeTrackingStaticData, 48);
ML_SIZE(MLEyeTrackingStateEx, 40);
ML_OFFSET(MLEyeTrackingStateEx, error, 20);
ML_OFFSET(MLEyeTrackingStateEx, timestamp, 24);
