/** Poses in the world, and their time. */
#pragma once

#include "xr_api.h"

/** One instant in both clocks. */
struct poses_time {
    XrTime time;
    int64_t boottime_nanos;
};

ml2s_result poses_now(struct poses_time *now, ml2s_error *error);

/** Converts an XrTime to CLOCK_BOOTTIME. */
ml2s_result poses_boottime_of(XrTime time, int64_t *boottime_nanos, ml2s_error *error);

/** Returns true if orientation and position are tracked and the pose is valid. */
bool poses_is_tracked(XrSpaceLocationFlags flags, const XrPosef *pose);

/** Returns the pose of space at time. Without one, is_tracked is false and pose is unchanged. */
ml2s_result poses_locate(XrSpace space, XrTime time, XrPosef *pose, bool *is_tracked, ml2s_error *error);

/** Sets all fields of out; struct_size is 0. pose is read only if is_tracked. */
void poses_fill(ml2s_reading *out, uint32_t stream, const struct poses_time *now, const XrPosef *pose, bool is_tracked);
