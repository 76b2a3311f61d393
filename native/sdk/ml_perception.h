/**
 * The vendor's perception system: startup, snapshots of poses, head tracking, and the pose of the colour camera.
 * Before MLPerceptionStartup all other functions return PerceptionSystemNotStarted.
 */
#pragma once

#include "ml_types.h"

typedef struct MLPerceptionSettings {
    uint16_t override_port;
} MLPerceptionSettings;

typedef struct MLSnapshot MLSnapshot;

/** API level 30. */
typedef struct MLSnapshotStaticData {
    uint32_t version;
    MLCoordinateFrameUID coord_world_origin;
} MLSnapshotStaticData;

typedef struct MLTransformDerivatives {
    uint32_t version;
    MLVec3f linear_velocity_m_s;
    MLVec3f linear_acceleration_m_s2;
    MLVec3f angular_velocity_r_s;
    MLVec3f angular_acceleration_r_s2;
} MLTransformDerivatives;

/** API level 30. */
typedef struct MLPose {
    MLTransform transform;
    bool has_derivatives;
    MLVec3f linear_velocity, linear_acceleration, angular_velocity, angular_acceleration;
    MLTime origin_time_ns, predict_time_ns;
} MLPose;

typedef struct MLHeadTrackingStaticData {
    MLCoordinateFrameUID coord_frame_head;
} MLHeadTrackingStaticData;

enum {
    MLHeadTrackingStatus_Invalid = 0,
    MLHeadTrackingStatus_Initializing = 1,
    MLHeadTrackingStatus_Relocalizing = 2,
    MLHeadTrackingStatus_Valid = 100,
};

enum {
    MLHeadTrackingErrorFlag_None = 0,
    MLHeadTrackingErrorFlag_Unknown = 1u << 0,
    MLHeadTrackingErrorFlag_NotEnoughFeatures = 1u << 1,
    MLHeadTrackingErrorFlag_LowLight = 1u << 2,
    MLHeadTrackingErrorFlag_ExcessiveMotion = 1u << 3,
};

/** API level 26. */
typedef struct MLHeadTrackingStateEx {
    uint32_t version;
    uint32_t status;
    float confidence; /**< 0 to 1 */
    uint32_t error;
} MLHeadTrackingStateEx;

/** RecoveryFailed and NewSession invalidate all earlier transforms. */
enum {
    MLHeadTrackingMapEvent_Lost = 1u << 0,
    MLHeadTrackingMapEvent_Recovered = 1u << 1,
    MLHeadTrackingMapEvent_RecoveryFailed = 1u << 2,
    MLHeadTrackingMapEvent_NewSession = 1u << 3,
};

typedef uint32_t MLCVCameraID;
enum { MLCVCameraID_ColorCamera = 0 };

static inline void MLHeadTrackingStateExInit(MLHeadTrackingStateEx *state) {
    memset(state, 0, sizeof *state);
    state->version = 1;
}

/** Startup affects the whole process. Each snapshot needs exactly one release. */
#define ML_PERCEPTION_FUNCTIONS(F)                                                                                     \
    F(MLPerceptionInitSettings, (MLPerceptionSettings * out_settings))                                                 \
    F(MLPerceptionStartup, (MLPerceptionSettings * settings))                                                          \
    F(MLPerceptionGetSnapshot, (MLSnapshot * *out_snapshot))                                                           \
    F(MLPerceptionReleaseSnapshot, (MLSnapshot * snapshot))

/** A predicted snapshot may be at most 100 ms ahead (API level 27). */
#define ML_SNAPSHOT_FUNCTIONS(F)                                                                                       \
    F(MLPerceptionGetPredictedSnapshot, (MLTime time, MLSnapshot * *out_snapshot))                                     \
    F(MLSnapshotGetTransform, (const MLSnapshot *snapshot, const MLCoordinateFrameUID *id, MLTransform *out_transform))

#define ML_HEAD_TRACKING_FUNCTIONS(F)                                                                                  \
    F(MLHeadTrackingCreate, (MLHandle * out_tracker))                                                                  \
    F(MLHeadTrackingDestroy, (MLHandle tracker))                                                                       \
    F(MLHeadTrackingGetStaticData, (MLHandle tracker, MLHeadTrackingStaticData * out_data))                            \
    F(MLHeadTrackingGetStateEx, (MLHandle tracker, MLHeadTrackingStateEx * inout_state))                               \
    F(MLHeadTrackingGetMapEvents, (MLHandle tracker, uint64_t * out_events))

/** The pose of the camera in the world. The history is short; older times return PoseNotFound. */
#define ML_CV_CAMERA_FUNCTIONS(F)                                                                                      \
    F(MLCVCameraTrackingCreate, (MLHandle * out_cv))                                                                   \
    F(MLCVCameraGetFramePose,                                                                                          \
      (MLHandle cv, MLHandle head_tracker, MLCVCameraID camera, MLTime time, MLTransform * out_transform))             \
    F(MLCVCameraTrackingDestroy, (MLHandle cv))

ML_PERCEPTION_FUNCTIONS(ML_PROTOTYPE)
ML_SNAPSHOT_FUNCTIONS(ML_PROTOTYPE)
ML_HEAD_TRACKING_FUNCTIONS(ML_PROTOTYPE)
ML_CV_CAMERA_FUNCTIONS(ML_PROTOTYPE)

ML_SIZE(MLPerceptionSettings, 2);
ML_SIZE(MLSnapshotStaticData, 24);
ML_SIZE(MLTransformDerivatives, 52);
ML_SIZE(MLPose, 96);
ML_SIZE(MLHeadTrackingStaticData, 16);
ML_SIZE(MLHeadTrackingStateEx, 16);
