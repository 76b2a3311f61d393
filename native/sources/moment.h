/** What the vendor says of one moment, as frames and poses say it. */
#pragma once

#include <stdbool.h>
#include <string.h>

#include "../sdk/clock.h"
#include "../sdk/ml_types.h"

#define NANOS_PER_MILLI UINT64_C(1000000)

/** Rounded up, so that a short timeout is still a wait. */
static inline uint64_t millis_of(uint64_t nanos) { return nanos / NANOS_PER_MILLI + (nanos % NANOS_PER_MILLI != 0); }

/** Poses and intrinsics that are not numbers are none. */
static inline bool are_finite(const float *values, int count) {
    bool are = true;
    for (int i = 0; i < count; i++) {
        are &= __builtin_isfinite(values[i]) != 0;
    }
    return are;
}

static inline void frame_set_pose(ml2s_frame *frame, const MLTransform *transform) {
    memcpy(frame->rotation, &transform->rotation, sizeof frame->rotation);
    memcpy(frame->position, &transform->position, sizeof frame->position);
    frame->has |= are_finite(frame->rotation, 4) && are_finite(frame->position, 3) ? ML2S_HAS_POSE : 0;
}

static inline void frame_set_pinhole(ml2s_frame *frame, MLVec2f focal_length, MLVec2f principal_point) {
    const float values[] = {focal_length.x, focal_length.y, principal_point.x, principal_point.y};
    for (int i = 0; i < 2; i++) {
        frame->focal_length[i] = values[i];
        frame->principal_point[i] = values[i + 2];
    }
    frame->has |= are_finite(values, 4) ? ML2S_HAS_INTRINSICS : 0;
}

static inline ml2s_result frame_set_time(ml2s_frame *frame, MLTime time, ml2s_error *error) {
    frame->device_nanos = time;
    return clock_boottime_of_mltime(time, &frame->capture_nanos, error);
}

static inline void pose_set(ml2s_pose *pose, const MLTransform *transform) {
    memcpy(pose->rotation, &transform->rotation, sizeof pose->rotation);
    memcpy(pose->position, &transform->position, sizeof pose->position);
    pose->is_tracked = are_finite(pose->rotation, 4) && are_finite(pose->position, 3);
}
