#include "poses.h"

#include <string.h>

#include "../sources/conversions.h"

#define SECOND_NANOS INT64_C(1000000000)

static int64_t nanos_of(const struct timespec *time) { return time->tv_sec * SECOND_NANOS + time->tv_nsec; }

ml2s_result poses_now(struct poses_time *now, ml2s_error *error) {
    struct timespec monotonic;
    clock_gettime(CLOCK_MONOTONIC, &monotonic);
    now->boottime_nanos = clock_boottime_of_monotonic(nanos_of(&monotonic));
    return XR_CALL(error, time, xrConvertTimespecTimeToTimeKHR, xr.instance, &monotonic, &now->time);
}

ml2s_result poses_boottime_of(XrTime time, int64_t *boottime_nanos, ml2s_error *error) {
    struct timespec monotonic;
    ml2s_result result = XR_CALL(error, time, xrConvertTimeToTimespecTimeKHR, xr.instance, time, &monotonic);
    if (!result) {
        *boottime_nanos = clock_boottime_of_monotonic(nanos_of(&monotonic));
    }
    return result;
}

bool poses_is_tracked(XrSpaceLocationFlags flags, const XrPosef *pose) {
    XrSpaceLocationFlags needed = XR_SPACE_LOCATION_ORIENTATION_VALID_BIT | XR_SPACE_LOCATION_POSITION_VALID_BIT |
                                  XR_SPACE_LOCATION_ORIENTATION_TRACKED_BIT | XR_SPACE_LOCATION_POSITION_TRACKED_BIT;
    return (flags & needed) == needed && is_pose((const float *)&pose->orientation, (const float *)&pose->position);
}

ml2s_result poses_locate(XrSpace space, XrTime time, XrPosef *pose, bool *is_tracked, ml2s_error *error) {
    XrSpaceLocation location = {.type = XR_TYPE_SPACE_LOCATION};
    XrResult located = xr.core.xrLocateSpace(space, xr.world, time, &location);
    // The runtime keeps a short history: a capture that is too old is delivered without pose.
    *is_tracked = XR_SUCCEEDED(located) && poses_is_tracked(location.locationFlags, &location.pose);
    if (*is_tracked) {
        *pose = location.pose;
    }
    return located == XR_ERROR_TIME_INVALID ? ML2S_OK : xr_result_of(located, "xrLocateSpace", error);
}

void poses_fill(ml2s_reading *out, uint32_t stream, const struct poses_time *now, const XrPosef *pose,
                bool is_tracked) {
    *out = (ml2s_reading){
        .stream = stream, .capture_nanos = now->boottime_nanos, .device_nanos = now->time, .is_tracked = is_tracked};
    if (is_tracked) {
        memcpy(out->rotation, &pose->orientation, sizeof out->rotation);
        memcpy(out->position, &pose->position, sizeof out->position);
    }
}
