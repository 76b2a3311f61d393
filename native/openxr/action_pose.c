// Sensors that are the pose of one action: the hand-held controller, and the gaze ray of both eyes together, which
// begins at its position and looks along -z.
#include "../sdk/error.h"
#include "../sources/source.h"
#include "actions.h"
#include "events.h"
#include "poses.h"
#include "runtime.h"

static struct action_pose {
    uint32_t stream;
    enum action action;
    enum xr_area area;
    const char *name;
    XrSpace space;
} gaze = {ML2S_STREAM_GAZE, ACTION_GAZE, XR_GAZE, "gaze", XR_NULL_HANDLE},
  controller = {ML2S_STREAM_CONTROLLER, ACTION_CONTROLLER, XR_CONTROLLER, "controller", XR_NULL_HANDLE};

static struct action_pose *pose_of(const ml2s_settings *settings) {
    return settings->sensor == ML2S_SENSOR_GAZE ? &gaze : &controller;
}

static ml2s_result check_eye_tracking(ml2s_error *error) {
    XrSystemEyeGazeInteractionPropertiesEXT properties_of_gaze = {
        .type = XR_TYPE_SYSTEM_EYE_GAZE_INTERACTION_PROPERTIES_EXT};
    XrSystemProperties properties = {.type = XR_TYPE_SYSTEM_PROPERTIES, .next = &properties_of_gaze};
    ml2s_result result = XR_CALL(error, core, xrGetSystemProperties, xr.instance, xr.system, &properties);
    return result || properties_of_gaze.supportsEyeGazeInteraction
               ? result
               : error_set(error, ML2S_NOT_AVAILABLE, 0, "not available: gaze (the system has no eye tracking)");
}

static ml2s_result prepare(const ml2s_settings *settings, ml2s_error *error) {
    struct action_pose *pose = pose_of(settings);
    ml2s_result result = actions_attach(pose->action, pose->name, error);
    if (result || (pose == &gaze && (result = check_eye_tracking(error)))) {
        return result;
    }
    return actions_create_space(pose->action, &pose->space, error);
}

static ml2s_result begin(const ml2s_settings *settings, ml2s_error *error) {
    return xr_begin(XR_AREA_BIT(pose_of(settings)->area), prepare, settings, error);
}

static ml2s_result end(const ml2s_settings *settings, ml2s_error *error) {
    return xr_end(XR_CALL(error, core, xrDestroySpace, pose_of(settings)->space), error);
}

/** Writes how the headset is worn and how well it knows the eyes, without which nobody can tell how exact a gaze is. */
static void write_condition(ml2s_reading *reading) {
    latest_event event;
    bool has_fit = !events_latest(XR_TYPE_EVENT_DATA_HEADSET_FIT_CHANGED_ML, &event, NULL);
    reading->values[ML2S_GAZE_FIT] = has_fit ? (float)event.fit.status : -1;
    bool has_calibration = !events_latest(XR_TYPE_EVENT_DATA_EYE_CALIBRATION_CHANGED_ML, &event, NULL);
    reading->values[ML2S_GAZE_CALIBRATION] = has_calibration ? (float)event.calibration.status : -1;
}

static ml2s_result poll_readings(const ml2s_settings *settings, struct readings *readings, ml2s_error *error) {
    const struct action_pose *pose = pose_of(settings);
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
    if (pose == &gaze) {
        write_condition(&reading);
    }
    readings_add(readings, &reading);
    return ML2S_OK;
}

const struct source_ops openxr_action_pose = {
    .require = xr_require, .open = begin, .poll_readings = poll_readings, .close = end};
