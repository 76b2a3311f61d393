/** Where things are in the world, and when. */
#pragma once

#include "xr_api.h"

/** One instant on both clocks. */
struct poses_time {
    XrTime time;
    int64_t boottime_nanos;
};

ml2s_result poses_now(struct poses_time *now, ml2s_error *error);

/** The CLOCK_BOOTTIME instant of an XrTime. */
ml2s_result poses_boottime_of(XrTime time, int64_t *boottime_nanos, ml2s_error *error);

/** Whether flags say that orientation and position are both known from tracking, and pose is one. */
bool poses_is_tracked(XrSpaceLocationFlags flags, const XrPosef *pose);

/** Where space was at time. is_tracked is false, and pose untouched, where the runtime knows none. */
ml2s_result poses_locate(XrSpace space, XrTime time, XrPosef *pose, bool *is_tracked, ml2s_error *error);

/** Sets all of out (struct_size to 0); pose is not looked at unless is_tracked. */
void poses_fill(ml2s_pose *out, uint32_t stream, const struct poses_time *now, const XrPosef *pose, bool is_tracked);
