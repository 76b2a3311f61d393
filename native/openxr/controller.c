// The hand-held controller: its pose, and its buttons, trigger and touchpad.
#include "../sources/source.h"
#include "action_pose.h"
#include "poses.h"
#include "runtime.h"

static struct action_pose controller = {.stream = ML2S_STREAM_CONTROLLER};

static ml2s_result prepare(const ml2s_settings *settings, ml2s_error *error) {
    (void)settings;
    ml2s_result result = actions_attach(ACTION_CONTROLLER, "controller", error);
    return result ? result : actions_create_space(ACTION_CONTROLLER, &controller.space, error);
}

static ml2s_result begin(const ml2s_settings *settings, ml2s_error *error) {
    return xr_begin(XR_AREA_BIT(XR_CONTROLLER), prepare, settings, error);
}

static ml2s_result end(const ml2s_settings *settings, ml2s_error *error) {
    (void)settings;
    return action_pose_end(&controller, error);
}

static ml2s_result poll_poses(const ml2s_settings *settings, ml2s_pose *poses, uint32_t *count, ml2s_error *error) {
    (void)settings;
    *count = 1;
    return action_pose_poll(&controller, poses, error);
}

const struct source_ops openxr_controller = {
    .require = xr_require, .open = begin, .poll_poses = poll_poses, .close = end};

static ml2s_result prepare_input(const ml2s_settings *settings, ml2s_error *error) {
    (void)settings;
    return actions_attach(ACTION_CONTROLLER, "controller", error);
}

static ml2s_result begin_input(const ml2s_settings *settings, ml2s_error *error) {
    return xr_begin(XR_AREA_BIT(XR_CONTROLLER), prepare_input, settings, error);
}

static ml2s_result end_input(const ml2s_settings *settings, ml2s_error *error) {
    (void)settings;
    return xr_end(ML2S_OK, error);
}

static ml2s_result read_touch(ml2s_input *input, ml2s_error *error) {
    XrActionStateBoolean touch;
    ml2s_result result = actions_get_bool(ACTION_TOUCH, &touch, error);
    input->is_touched = touch.isActive && touch.currentState;
    if (result || !input->is_touched || (result = actions_get_float(ACTION_TOUCH_X, &input->touch[0], error)) ||
        (result = actions_get_float(ACTION_TOUCH_Y, &input->touch[1], error))) {
        return result;
    }
    return actions_get_float(ACTION_FORCE, &input->force, error);
}

static ml2s_result read_buttons(ml2s_input *input, ml2s_error *error) {
    XrActionStateBoolean bumper, menu;
    ml2s_result result = actions_get_bool(ACTION_BUMPER, &bumper, error);
    if (result || (result = actions_get_bool(ACTION_MENU, &menu, error)) ||
        (result = actions_get_float(ACTION_TRIGGER, &input->trigger, error))) {
        return result;
    }
    input->is_connected = bumper.isActive;
    input->bumper = bumper.isActive && bumper.currentState;
    input->menu = menu.isActive && menu.currentState;
    return read_touch(input, error);
}

static ml2s_result poll_input(const ml2s_settings *settings, ml2s_input *input, ml2s_error *error) {
    (void)settings;
    struct poses_time now;
    *input = (ml2s_input){0};
    ml2s_result result = xr_handle_events(error);
    if (result || (result = actions_sync(error)) || (result = poses_now(&now, error))) {
        return result;
    }
    input->device_nanos = now.time;
    input->capture_nanos = now.boottime_nanos;
    return read_buttons(input, error);
}

const struct source_ops openxr_controller_input = {
    .require = xr_require, .open = begin_input, .poll_input = poll_input, .close = end_input};
