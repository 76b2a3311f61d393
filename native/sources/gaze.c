// The gaze of both eyes: a pose between the eyes that looks along -z.
#include "../sdk/dump.h"
#include "../sdk/snapshot.h"
#include "conversions.h"
#include "head_tracker.h"
#include "source.h"

static MLHandle head_tracker;
static MLHandle tracker;
static MLEyeTrackingStaticData eyes;

static ml2s_result end(const ml2s_settings *, ml2s_error *error) {
    return head_tracker_close_after(SDK_CALL(error, eye_tracking, MLEyeTrackingDestroy, tracker), head_tracker, error);
}

static ml2s_result begin(const ml2s_settings *settings, ml2s_error *error) {
    ml2s_result result = head_tracker_open(&head_tracker, error);
    if (result || (result = head_tracker_close_on_failure(SDK_CALL(error, eye_tracking, MLEyeTrackingCreate, &tracker),
                                                          head_tracker))) {
        return result;
    }
    result = SDK_CALL(error, eye_tracking, MLEyeTrackingGetStaticData, tracker, &eyes);
    if (result) {
        end(settings, NULL);
    }
    return result;
}

static bool is_valid(const MLTransform *eye) {
    return is_pose((const float *)&eye->rotation, (const float *)&eye->position);
}

/** Returns the mean of two poses that are close to each other. */
static MLTransform average(const MLTransform *left, const MLTransform *right) {
    const MLQuaternionf *l = &left->rotation, *r = &right->rotation;
    float sign = l->x * r->x + l->y * r->y + l->z * r->z + l->w * r->w < 0 ? -1 : 1;
    MLQuaternionf sum = {l->x + sign * r->x, l->y + sign * r->y, l->z + sign * r->z, l->w + sign * r->w};
    float scale = 1 / __builtin_sqrtf(sum.x * sum.x + sum.y * sum.y + sum.z * sum.z + sum.w * sum.w);
    return (MLTransform){
        {sum.x * scale, sum.y * scale, sum.z * scale, sum.w * scale},
        {(left->position.x + right->position.x) / 2, (left->position.y + right->position.y) / 2,
         (left->position.z + right->position.z) / 2},
    };
}

static ml2s_result locate(ml2s_reading *pose, ml2s_error *error) {
    struct snapshot snapshot;
    ml2s_result result = snapshot_take(pose->device_nanos, &snapshot, error);
    if (result) {
        return result;
    }
    MLTransform left, right;
    result = SDK_CALL(error, snapshot, MLSnapshotGetTransform, snapshot.of, &eyes.left_center, &left);
    if (!result) {
        result = SDK_CALL(error, snapshot, MLSnapshotGetTransform, snapshot.of, &eyes.right_center, &right);
    }
    if (!result && is_valid(&left) && is_valid(&right)) {
        MLTransform gaze = average(&left, &right);
        pose_set(pose, &gaze);
    }
    return snapshot_release(snapshot, result, error);
}

static bool are_seen(const MLEyeTrackingStateEx *state) {
    return !state->error && state->left_center_confidence > 0 && state->right_center_confidence > 0;
}

static ml2s_result poll_readings(const ml2s_settings *, struct readings *readings, ml2s_error *error) {
    WITH_ROOM(MLEyeTrackingStateEx) state;
    dump_begin(state.room);
    MLEyeTrackingStateInit(&state.of);
    ml2s_reading pose;
    ml2s_result result = SDK_CALL(error, eye_tracking, MLEyeTrackingGetStateEx, tracker, &state.of);
    if (result) {
        return result;
    }
    DUMP_ONCE("MLEyeTrackingStateEx", state);
    if ((result = pose_begin(&pose, ML2S_STREAM_GAZE, error)) ||
        (are_seen(&state.of) && (result = locate(&pose, error)))) {
        return result;
    }
    readings_add(readings, &pose);
    return ML2S_OK;
}

const struct source_ops source_gaze = {.areas = HEAD_TRACKER_AREAS | 1u << SDK_EYE_TRACKING | 1u << SDK_SNAPSHOT,
                                       .open = begin,
                                       .poll_readings = poll_readings,
                                       .close = end};
