/** Conversions of the vendor's times, poses and intrinsics into frames and poses. */
#pragma once

#include <stdbool.h>
#include <string.h>

#include "../sdk/clock.h"
#include "../sdk/ml_types.h"

#define NANOS_PER_MILLI UINT64_C(1000000)

/** Rounds up, so that a short timeout is not 0. */
static inline uint64_t millis_of(uint64_t nanos) { return nanos / NANOS_PER_MILLI + (nanos % NANOS_PER_MILLI != 0); }

/** Returns true if no value is NaN or infinite. */
static inline bool are_finite(const float *values, int count) {
    bool are = true;
    for (int i = 0; i < count; i++) {
        are &= __builtin_isfinite(values[i]) != 0;
    }
    return are;
}

/** Returns true if the pose is finite and its quaternion has length 1 within the tolerance of ROS. */
static inline bool is_pose(const float *rotation, const float *position) {
    float square = 0;
    for (int i = 0; i < 4; i++) {
        square += rotation[i] * rotation[i];
    }
    return square > 0.99f && square < 1.01f && are_finite(position, 3);
}

static inline void frame_set_pose(ml2s_frame *frame, const MLTransform *transform) {
    memcpy(frame->rotation, &transform->rotation, sizeof frame->rotation);
    memcpy(frame->position, &transform->position, sizeof frame->position);
    frame->has |= is_pose(frame->rotation, frame->position) ? ML2S_HAS_POSE : 0;
}

/** Returns true if the numbers are those of a lens: finite, and with a focal length that pixels can be divided by. */
static inline bool is_lens(const ml2s_frame *frame) {
    bool is = true;
    for (int i = 0; i < 6; i++) {
        is &= __builtin_isfinite(frame->distortion[i]) != 0;
    }
    for (int i = 0; i < 2; i++) {
        is &= frame->focal_length[i] > 0 && frame->focal_length[i] < 1e6;
        is &= __builtin_fabs(frame->principal_point[i]) < 1e6;
    }
    return is;
}

/** Sets the intrinsics; the distortion is set before. */
static inline void frame_set_pinhole(ml2s_frame *frame, MLVec2f focal_length, MLVec2f principal_point) {
    const float values[] = {focal_length.x, focal_length.y, principal_point.x, principal_point.y};
    for (int i = 0; i < 2; i++) {
        frame->focal_length[i] = values[i];
        frame->principal_point[i] = values[i + 2];
    }
    frame->has |= is_lens(frame) ? ML2S_HAS_INTRINSICS : 0;
}

static inline ml2s_result frame_set_time(ml2s_frame *frame, MLTime time, ml2s_error *error) {
    frame->device_nanos = time;
    return clock_boottime_of_mltime(time, &frame->capture_nanos, error);
}

/** Makes an untracked pose with the current time. */
static inline ml2s_result pose_begin(ml2s_reading *pose, uint32_t stream, ml2s_error *error) {
    *pose = (ml2s_reading){.stream = stream};
    ml2s_result result = clock_mltime_now(&pose->device_nanos, error);
    return result ? result : clock_boottime_of_mltime(pose->device_nanos, &pose->capture_nanos, error);
}

static inline void pose_set(ml2s_reading *pose, const MLTransform *transform) {
    memcpy(pose->rotation, &transform->rotation, sizeof pose->rotation);
    memcpy(pose->position, &transform->position, sizeof pose->position);
    pose->is_tracked = is_pose(pose->rotation, pose->position);
}
