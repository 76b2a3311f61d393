#include "head_tracker.h"

#include "../sdk/snapshot.h"
#include "conversions.h"

ml2s_result head_tracker_open(MLHandle *tracker, ml2s_error *error) {
    ml2s_result result = perception_start(error);
    return result ? result : SDK_CALL(error, head, MLHeadTrackingCreate, tracker);
}

ml2s_result head_tracker_close_on_failure(ml2s_result result, MLHandle tracker) {
    if (result) {
        head_tracker_close(tracker, NULL);
    }
    return result;
}

ml2s_result head_tracker_close_after(ml2s_result result, MLHandle tracker, ml2s_error *error) {
    ml2s_result closed = head_tracker_close(tracker, result ? NULL : error);
    return result ? result : closed;
}

ml2s_result head_tracker_close(MLHandle tracker, ml2s_error *error) {
    return SDK_CALL(error, head, MLHeadTrackingDestroy, tracker);
}

ml2s_result pose_locate(const MLCoordinateFrameUID *frame, ml2s_reading *pose, ml2s_error *error) {
    struct snapshot snapshot;
    ml2s_result result = snapshot_take(pose->device_nanos, &snapshot, error);
    if (result) {
        return result;
    }
    MLTransform transform;
    result = SDK_CALL(error, snapshot, MLSnapshotGetTransform, snapshot.of, frame, &transform);
    if (!result) {
        pose_set(pose, &transform);
    }
    return snapshot_release(snapshot, result, error);
}
