/** What the vendor says of one moment, as frames and poses say it. */
#pragma once

#include <string.h>

#include "../sdk/clock.h"
#include "../sdk/ml_types.h"

#define NANOS_PER_MILLI UINT64_C(1000000)

/** Rounded up, so that a short timeout is still a wait. */
static inline uint64_t millis_of(uint64_t nanos) { return nanos / NANOS_PER_MILLI + (nanos % NANOS_PER_MILLI != 0); }

static inline void frame_set_pose(ml2s_frame *frame, const MLTransform *transform) {
    memcpy(frame->rotation, &transform->rotation, sizeof frame->rotation);
    memcpy(frame->position, &transform->position, sizeof frame->position);
    frame->has |= ML2S_HAS_POSE;
}

static inline void frame_set_pinhole(ml2s_frame *frame, MLVec2f focal_length, MLVec2f principal_point) {
    frame->focal_length[0] = focal_length.x;
    frame->focal_length[1] = focal_length.y;
    frame->principal_point[0] = principal_point.x;
    frame->principal_point[1] = principal_point.y;
    frame->has |= ML2S_HAS_INTRINSICS;
}

static inline ml2s_result frame_set_time(ml2s_frame *frame, MLTime time, ml2s_error *error) {
    frame->device_nanos = time;
    return clock_boottime_of_mltime(time, &frame->capture_nanos, error);
}

static inline void pose_set(ml2s_pose *pose, const MLTransform *transform) {
    memcpy(pose->rotation, &transform->rotation, sizeof pose->rotation);
    memcpy(pose->position, &transform->position, sizeof pose->position);
    pose->is_tracked = 1;
}
