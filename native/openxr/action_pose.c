#include "action_pose.h"

#include "poses.h"
#include "runtime.h"

ml2s_result action_pose_end(struct action_pose *pose, ml2s_error *error) {
    ml2s_result result = XR_CALL(error, core, xrDestroySpace, pose->space);
    pose->space = XR_NULL_HANDLE;
    return xr_end(result, error);
}

ml2s_result action_pose_poll(const struct action_pose *pose, struct readings *readings, ml2s_error *error) {
    struct poses_time now;
    ml2s_reading reading;
    XrPosef located;
    bool is_tracked;
    ml2s_result result = xr_handle_events(error);
    if (result || (result = actions_sync(error)) || (result = poses_now(&now, error)) ||
        (result = poses_locate(pose->space, now.time, &located, &is_tracked, error))) {
        return result;
    }
    poses_fill(&reading, pose->stream, &now, &located, is_tracked);
    readings_add(readings, &reading);
    return ML2S_OK;
}
