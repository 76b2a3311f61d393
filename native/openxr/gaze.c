// The gaze ray of both eyes together: its origin and, along -z, its direction.
#include "../sdk/error.h"
#include "../sources/source.h"
#include "action_pose.h"
#include "runtime.h"

static struct action_pose gaze = {.stream = ML2S_STREAM_GAZE};

static ml2s_result check_system(ml2s_error *error) {
    XrSystemEyeGazeInteractionPropertiesEXT properties_of_gaze = {
        .type = XR_TYPE_SYSTEM_EYE_GAZE_INTERACTION_PROPERTIES_EXT};
    XrSystemProperties properties = {.type = XR_TYPE_SYSTEM_PROPERTIES, .next = &properties_of_gaze};
    ml2s_result result = XR_CALL(error, core, xrGetSystemProperties, xr.instance, xr.system, &properties);
    return result || properties_of_gaze.supportsEyeGazeInteraction
               ? result
               : error_set(error, ML2S_NOT_AVAILABLE, 0, "not available: gaze (the system has no eye tracking)");
}

static ml2s_result prepare(const ml2s_settings *settings, ml2s_error *error) {
    (void)settings;
    ml2s_result result = actions_attach(ACTION_GAZE, "gaze", error);
    if (result || (result = check_system(error))) {
        return result;
    }
    return actions_create_space(ACTION_GAZE, &gaze.space, error);
}

static ml2s_result begin(const ml2s_settings *settings, ml2s_error *error) {
    return xr_begin(XR_AREA_BIT(XR_GAZE), prepare, settings, error);
}

static ml2s_result end(const ml2s_settings *settings, ml2s_error *error) {
    (void)settings;
    return action_pose_end(&gaze, error);
}

static ml2s_result poll_readings(const ml2s_settings *settings, struct readings *readings, ml2s_error *error) {
    (void)settings;
    return action_pose_poll(&gaze, readings, error);
}

const struct source_ops openxr_gaze = {
    .require = xr_require, .open = begin, .poll_readings = poll_readings, .close = end};
