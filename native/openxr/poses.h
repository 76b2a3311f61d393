/** Where things are in the world, and when. */
#pragma once

#include "xr_api.h"

/** The present as XrTime. */
ml2s_result poses_now(XrTime *now, ml2s_error *error);

/** The CLOCK_BOOTTIME instant of an XrTime. */
ml2s_result poses_boottime_of(XrTime time, int64_t *boottime_nanos, ml2s_error *error);

/** Whether flags say that orientation and position are both known, and known from tracking. */
bool poses_is_tracked(XrSpaceLocationFlags flags);

/** Where space was at time. is_tracked is false, and pose untouched, where the runtime knows none. */
ml2s_result poses_locate(XrSpace space, XrTime time, XrPosef *pose, bool *is_tracked, ml2s_error *error);

/** One pose of stream at now; is_tracked as poses_locate says. */
void poses_fill(ml2s_pose *out, uint32_t stream, XrTime now, int64_t boottime_nanos, const XrPosef *pose,
                bool is_tracked);
