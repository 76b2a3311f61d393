/**
 * The vendor's hand tracker (API level 28). Snapshots hold the poses of its key points.
 */
#pragma once

#include "ml_types.h"

enum {
    MLHandTrackingHandType_Left = 0,
    MLHandTrackingHandType_Right = 1,
    MLHandTrackingHandType_Count = 2,
};

/** Key points from the tip of each finger to the wrist. The metacarpals are last. */
enum {
    MLHandTrackingKeyPoint_Thumb_Tip = 0,
    MLHandTrackingKeyPoint_Thumb_IP = 1,
    MLHandTrackingKeyPoint_Thumb_MCP = 2,
    MLHandTrackingKeyPoint_Thumb_CMC = 3,
    MLHandTrackingKeyPoint_Index_Tip = 4,
    MLHandTrackingKeyPoint_Index_DIP = 5,
    MLHandTrackingKeyPoint_Index_PIP = 6,
    MLHandTrackingKeyPoint_Index_MCP = 7,
    MLHandTrackingKeyPoint_Middle_Tip = 8,
    MLHandTrackingKeyPoint_Middle_DIP = 9,
    MLHandTrackingKeyPoint_Middle_PIP = 10,
    MLHandTrackingKeyPoint_Middle_MCP = 11,
    MLHandTrackingKeyPoint_Ring_Tip = 12,
    MLHandTrackingKeyPoint_Ring_DIP = 13,
    MLHandTrackingKeyPoint_Ring_PIP = 14,
    MLHandTrackingKeyPoint_Ring_MCP = 15,
    MLHandTrackingKeyPoint_Pinky_Tip = 16,
    MLHandTrackingKeyPoint_Pinky_DIP = 17,
    MLHandTrackingKeyPoint_Pinky_PIP = 18,
    MLHandTrackingKeyPoint_Pinky_MCP = 19,
    MLHandTrackingKeyPoint_Wrist_Center = 20,
    MLHandTrackingKeyPoint_Wrist_Ulnar = 21,
    MLHandTrackingKeyPoint_Wrist_Radial = 22,
    MLHandTrackingKeyPoint_Hand_Center = 23,
    MLHandTrackingKeyPoint_Index_Meta = 24,
    MLHandTrackingKeyPoint_Middle_Meta = 25,
    MLHandTrackingKeyPoint_Ring_Meta = 26,
    MLHandTrackingKeyPoint_Pinky_Meta = 27,
    MLHandTrackingKeyPoint_Count = 28,
};

typedef struct MLHandTrackingCFUIDs {
    MLCoordinateFrameUID keypoint_cfuids[MLHandTrackingKeyPoint_Count];
} MLHandTrackingCFUIDs;

/** Coordinate frames of each hand. Filtered ones always exist. */
typedef struct MLHandTrackingStaticData {
    uint32_t version;
    MLHandTrackingCFUIDs hand_cfuids[MLHandTrackingHandType_Count];
    MLHandTrackingCFUIDs unfiltered_hand_cfuids[MLHandTrackingHandType_Count];
} MLHandTrackingStaticData;

typedef struct MLHandTrackingHandState {
    bool is_hand_detected;
    float hand_confidence; /**< 0 to 1 */
    bool keypoints_mask[MLHandTrackingKeyPoint_Count];
} MLHandTrackingHandState;

typedef struct MLHandTrackingData {
    uint32_t version;
    MLHandTrackingHandState hand_state[MLHandTrackingHandType_Count];
    MLTime timestamp_ns; /**< Time of the last measurement. */
} MLHandTrackingData;

typedef struct MLHandTrackingSettings {
    uint32_t version;
    uint32_t flags; /**< 1: unfiltered key points too. */
} MLHandTrackingSettings;

static inline void MLHandTrackingStaticDataInit(MLHandTrackingStaticData *data) {
    memset(data, 0, sizeof *data);
    data->version = 3;
}

static inline void MLHandTrackingDataInit(MLHandTrackingData *data) {
    memset(data, 0, sizeof *data);
    data->version = 3;
}

static inline void MLHandTrackingSettingsInit(MLHandTrackingSettings *settings) {
    memset(settings, 0, sizeof *settings);
    settings->version = 1;
}

#define ML_HAND_TRACKING_FUNCTIONS(F)                                                                                  \
    F(MLHandTrackingCreateEx, (const MLHandTrackingSettings *settings, MLHandle *out_tracker))                         \
    F(MLHandTrackingDestroy, (MLHandle tracker))                                                                       \
    F(MLHandTrackingGetData, (MLHandle tracker, MLHandTrackingData * inout_data))                                      \
    F(MLHandTrackingGetStaticData, (MLHandle tracker, MLHandTrackingStaticData * inout_data))

ML_HAND_TRACKING_FUNCTIONS(ML_PROTOTYPE)

ML_SIZE(MLHandTrackingStaticData, 1800);
ML_OFFSET(MLHandTrackingStaticData, hand_cfuids, 8);
ML_SIZE(MLHandTrackingHandState, 36);
ML_SIZE(MLHandTrackingData, 88);
ML_OFFSET(MLHandTrackingData, timestamp_ns, 80);
ML_SIZE(MLHandTrackingSettings, 8);
