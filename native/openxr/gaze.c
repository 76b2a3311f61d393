// The gaze ray of both eyes together: its origin and, along -z, its direction.
#include "gaze.h"

#include "../sdk/error.h"
#include "../sources/source.h"
#include "poses.h"
#include "runtime.h"

// Action sets can be attached once per session, so these objects live as long as the session.
static XrActionSet action_set;
static XrAction action;
static XrSpace space;

static bool is_open;

static ml2s_result check_system(ml2s_error *error) {
    XrSystemEyeGazeInteractionPropertiesEXT gaze = {.type = XR_TYPE_SYSTEM_EYE_GAZE_INTERACTION_PROPERTIES_EXT};
    XrSystemProperties properties = {.type = XR_TYPE_SYSTEM_PROPERTIES, .next = &gaze};
    ml2s_result result = XR_CALL(error, core, xrGetSystemProperties, xr.instance, xr.system, &properties);
    return result || gaze.supportsEyeGazeInteraction
               ? result
               : error_set(error, ML2S_NOT_AVAILABLE, 0, "not available: gaze (the system has no eye tracking)");
}

static ml2s_result create_action(ml2s_error *error) {
    XrActionSetCreateInfo set = {
        .type = XR_TYPE_ACTION_SET_CREATE_INFO, .actionSetName = "gaze", .localizedActionSetName = "Gaze"};
    XrActionCreateInfo info = {.type = XR_TYPE_ACTION_CREATE_INFO,
                               .actionName = "gaze",
                               .actionType = XR_ACTION_TYPE_POSE_INPUT,
                               .localizedActionName = "Gaze"};
    ml2s_result result = XR_CALL(error, gaze, xrCreateActionSet, xr.instance, &set, &action_set);
    return result ? result : XR_CALL(error, gaze, xrCreateAction, action_set, &info, &action);
}

static ml2s_result bind(ml2s_error *error) {
    XrPath profile;
    XrActionSuggestedBinding binding = {.action = action};
    ml2s_result result =
        XR_CALL(error, core, xrStringToPath, xr.instance, "/interaction_profiles/ext/eye_gaze_interaction", &profile);
    if (result || (result = XR_CALL(error, core, xrStringToPath, xr.instance, "/user/eyes_ext/input/gaze_ext/pose",
                                    &binding.binding))) {
        return result;
    }
    XrInteractionProfileSuggestedBinding suggestion = {XR_TYPE_INTERACTION_PROFILE_SUGGESTED_BINDING, NULL, profile, 1,
                                                       &binding};
    XrSessionActionSetsAttachInfo attach = {XR_TYPE_SESSION_ACTION_SETS_ATTACH_INFO, NULL, 1, &action_set};
    result = XR_CALL(error, gaze, xrSuggestInteractionProfileBindings, xr.instance, &suggestion);
    return result ? result : XR_CALL(error, gaze, xrAttachSessionActionSets, xr.session, &attach);
}

static ml2s_result create_space(ml2s_error *error) {
    XrActionSpaceCreateInfo info = {
        .type = XR_TYPE_ACTION_SPACE_CREATE_INFO, .action = action, .poseInActionSpace = {{0, 0, 0, 1}, {0, 0, 0}}};
    return XR_CALL(error, gaze, xrCreateActionSpace, xr.session, &info, &space);
}

static ml2s_result prepare(const ml2s_settings *settings, ml2s_error *error) {
    (void)settings;
    if (xr.is_borrowed) {
        return error_set(error, ML2S_NOT_AVAILABLE, 0,
                         "not available: gaze in the app's session (attaching action sets would break the app's)");
    }
    if (!space) {
        ml2s_result result = check_system(error);
        if (result || (result = create_action(error)) || (result = bind(error)) || (result = create_space(error))) {
            gaze_destroy(NULL);
            return result;
        }
    }
    is_open = true;
    return ML2S_OK;
}

static ml2s_result begin(const ml2s_settings *settings, ml2s_error *error) {
    return xr_begin(XR_AREA_BIT(XR_GAZE), prepare, settings, error);
}

static ml2s_result end(const ml2s_settings *settings, ml2s_error *error) {
    (void)settings;
    if (!is_open) {
        return ML2S_OK;
    }
    is_open = false;
    return xr_end(ML2S_OK, error);
}

ml2s_result gaze_destroy(ml2s_error *error) {
    ml2s_result first = ML2S_OK;
    if (space) {
        first = XR_CALL(error, core, xrDestroySpace, space);
    }
    if (action) {
        ml2s_result result = XR_CALL(first ? NULL : error, gaze, xrDestroyAction, action);
        first = first ? first : result;
    }
    if (action_set) {
        ml2s_result result = XR_CALL(first ? NULL : error, gaze, xrDestroyActionSet, action_set);
        first = first ? first : result;
    }
    space = XR_NULL_HANDLE;
    action = XR_NULL_HANDLE;
    action_set = XR_NULL_HANDLE;
    return first;
}

static ml2s_result poll_poses(const ml2s_settings *settings, ml2s_pose *poses, uint32_t *count, ml2s_error *error) {
    (void)settings;
    XrActiveActionSet active = {action_set, XR_NULL_PATH};
    XrActionsSyncInfo sync = {XR_TYPE_ACTIONS_SYNC_INFO, NULL, 1, &active};
    struct poses_time now;
    XrPosef pose;
    bool is_tracked;
    ml2s_result result = xr_handle_events(error);
    if (result || (result = XR_CALL(error, gaze, xrSyncActions, xr.session, &sync)) ||
        (result = poses_now(&now, error)) || (result = poses_locate(space, now.time, &pose, &is_tracked, error))) {
        return result;
    }
    poses_fill(poses, ML2S_STREAM_GAZE, &now, &pose, is_tracked);
    *count = 1;
    return ML2S_OK;
}

const struct source_ops openxr_gaze = {
    .require = xr_require, .open = begin, .poll_poses = poll_poses, .pause = end, .resume = begin, .close = end};
