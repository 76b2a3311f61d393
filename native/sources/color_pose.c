// The pose of the colour camera. Its images come from Camera2.
#include "../sdk/snapshot.h"
#include "conversions.h"
#include "head_tracker.h"
#include "source.h"

static MLHandle head_tracker;
static MLHandle camera_tracker;

static ml2s_result begin(const ml2s_settings *, ml2s_error *error) {
    ml2s_result result = head_tracker_open(&head_tracker, error);
    return result ? result
                  : head_tracker_close_on_failure(SDK_CALL(error, cv, MLCVCameraTrackingCreate, &camera_tracker),
                                                  head_tracker);
}

static ml2s_result end(const ml2s_settings *, ml2s_error *error) {
    return head_tracker_close_after(SDK_CALL(error, cv, MLCVCameraTrackingDestroy, camera_tracker), head_tracker,
                                    error);
}

/** Returns ML2S_NO_POSE after any failure, so that the image is still delivered. */
static ml2s_result color_pose(const ml2s_settings *, int64_t device_nanos, ml2s_reading *pose, ml2s_error *error) {
    MLTransform transform;
    *pose = (ml2s_reading){.stream = ML2S_STREAM_COLOR, .device_nanos = device_nanos};
    // In an app that renders with OpenXR, poses are current only while snapshots are taken.
    if (result_of(snapshot_touch(), "MLPerceptionGetSnapshot", error) ||
        SDK_CALL(error, cv, MLCVCameraGetFramePose, camera_tracker, head_tracker, MLCVCameraID_ColorCamera,
                 device_nanos, &transform) ||
        clock_boottime_of_mltime(device_nanos, &pose->capture_nanos, error)) {
        return ML2S_NO_POSE;
    }
    pose_set(pose, &transform);
    return ML2S_OK;
}

const struct source_ops source_color_pose = {
    .areas = HEAD_TRACKER_AREAS | 1u << SDK_CV, .open = begin, .color_pose = color_pose, .close = end};
