// Buttons, trigger and touchpad of the hand-held controller.
#include "../sources/source.h"
#include "actions.h"
#include "poses.h"
#include "runtime.h"

static ml2s_result prepare(const ml2s_settings *, ml2s_error *error) {
    return actions_attach(ACTION_CONTROLLER, "controller", error);
}

static ml2s_result begin(const ml2s_settings *settings, ml2s_error *error) {
    return xr_begin(XR_AREA_BIT(XR_CONTROLLER), prepare, settings, error);
}

static ml2s_result end(const ml2s_settings *, ml2s_error *error) { return xr_end(ML2S_OK, error); }

static ml2s_result read_touch(float *values, ml2s_error *error) {
    XrActionStateBoolean touch;
    ml2s_result result = actions_get_bool(ACTION_TOUCH, &touch, error);
    bool is_touched = touch.isActive && touch.currentState;
    values[ML2S_INPUT_TOUCHED] = is_touched;
    if (result || !is_touched || (result = actions_get_float(ACTION_TOUCH_X, &values[ML2S_INPUT_TOUCH_X], error)) ||
        (result = actions_get_float(ACTION_TOUCH_Y, &values[ML2S_INPUT_TOUCH_Y], error))) {
        return result;
    }
    return actions_get_float(ACTION_FORCE, &values[ML2S_INPUT_FORCE], error);
}

static ml2s_result read_buttons(ml2s_reading *input, ml2s_error *error) {
    XrActionStateBoolean bumper, menu;
    ml2s_result result = actions_get_bool(ACTION_BUMPER, &bumper, error);
    if (result || (result = actions_get_bool(ACTION_MENU, &menu, error)) ||
        (result = actions_get_float(ACTION_TRIGGER, &input->values[ML2S_INPUT_TRIGGER], error))) {
        return result;
    }
    input->is_tracked = bumper.isActive;
    input->values[ML2S_INPUT_BUMPER] = bumper.isActive && bumper.currentState;
    input->values[ML2S_INPUT_MENU] = menu.isActive && menu.currentState;
    return read_touch(input->values, error);
}

static ml2s_result poll_input(const ml2s_settings *, struct readings *readings, ml2s_error *error) {
    struct poses_time now;
    ml2s_result result = xr_handle_events(error);
    if (result || (result = actions_sync(error)) || (result = poses_now(&now, error))) {
        return result;
    }
    ml2s_reading input;
    poses_fill(&input, ML2S_STREAM_CONTROLLER_JOY, &now, NULL, false);
    if (!(result = read_buttons(&input, error))) {
        readings_add(readings, &input);
    }
    return result;
}

const struct source_ops openxr_controller_input = {
    .require = xr_require, .open = begin, .poll_readings = poll_input, .close = end};
