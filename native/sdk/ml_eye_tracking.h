/**
 * The vendor's eye tracker (API level 26). Its coordinate frames are in snapshots; gaze is along -z.
 */
#pragma once

#include "ml_types.h"

/** Where the rays of both eyes meet, and the centres of the eyes, each turned to where its eye looks. */
typedef struct MLEyeTrackingStaticData {
    MLCoordinateFrameUID vergence;
    MLCoordinateFrameUID left_center, right_center;
} MLEyeTrackingStaticData;

/** Of confidence 0 to 1; what has none means nothing. */
typedef struct MLEyeTrackingStateEx {
    uint32_t version;
    float vergence_confidence, left_center_confidence, right_center_confidence;
    bool left_blink, right_blink;
    uint32_t error; /**< 0: none. */
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
