// The hand-held controller: its pose at the instant of its stamp, and its buttons, trigger and touchpad.
#include "../sdk/dump.h"
#include "../sdk/error.h"
#include "conversions.h"
#include "head_tracker.h"
#include "source.h"

static MLHandle head_tracker;
static MLHandle tracker;

static ml2s_result begin(const ml2s_settings *, ml2s_error *error) {
    static const MLControllerConfiguration modes = {.enable_fused6dof = true};
    ml2s_result result = head_tracker_open(&head_tracker, error);
    return result ? result
                  : head_tracker_close_on_failure(SDK_CALL(error, controller, MLControllerCreateEx, &modes, &tracker),
                                                  head_tracker);
}

static ml2s_result end(const ml2s_settings *, ml2s_error *error) {
    return head_tracker_close_after(SDK_CALL(error, controller, MLControllerDestroy, tracker), head_tracker, error);
}

static ml2s_result poll_readings(const ml2s_settings *, struct readings *readings, ml2s_error *error) {
    WITH_ROOM(MLControllerSystemStateEx) state;
    dump_begin(state.room);
    MLControllerSystemStateExInit(&state.of);
    ml2s_reading pose;
    ml2s_result result = SDK_CALL(error, controller, MLControllerGetStateEx, tracker, &state.of);
    if (result) {
        return result;
    }
    DUMP_ONCE("MLControllerSystemStateEx", state);
    // With rotation only, the position is where the controller was last seen, which a pose cannot say.
    const MLControllerStateEx *controller = &state.of.controller_state[0];
    if ((result = pose_begin(&pose, ML2S_STREAM_CONTROLLER, error)) ||
        (controller->status == MLControllerStatus_Active &&
         (result = pose_locate(&controller->coord_frame_controller, &pose, error)))) {
        return result;
    }
    readings_add(readings, &pose);
    return ML2S_OK;
}

const struct source_ops source_controller = {.areas = HEAD_TRACKER_AREAS | 1u << SDK_CONTROLLER | 1u << SDK_SNAPSHOT,
                                             .open = begin,
                                             .poll_readings = poll_readings,
                                             .close = end};

static MLHandle input_tracker;

static ml2s_result begin_input(const ml2s_settings *, ml2s_error *error) {
    return SDK_CALL(error, input, MLInputCreate, &input_tracker);
}

static ml2s_result end_input(const ml2s_settings *, ml2s_error *error) {
    return SDK_CALL(error, input, MLInputDestroy, input_tracker);
}

/** Copies the state of a connected controller. Only the first touch counts: the controller tells one finger apart. */
static ml2s_result copy_input(const MLInputControllerStateEx *from, ml2s_reading *input, ml2s_error *error) {
    const MLVec3f *touch = &from->touch_pos_and_force[0];
    bool is_touched = from->is_touch_active[0];
    const float values[ML2S_INPUT_COUNT] = {
        [ML2S_INPUT_TRIGGER] = from->trigger_normalized,
        [ML2S_INPUT_BUMPER] = from->button_state[MLInputControllerButton_Bumper],
        [ML2S_INPUT_MENU] = from->button_state[MLInputControllerButton_Menu],
        [ML2S_INPUT_TOUCHED] = is_touched,
        [ML2S_INPUT_TOUCH_X] = is_touched ? touch->x : 0,
        [ML2S_INPUT_TOUCH_Y] = is_touched ? touch->y : 0,
        [ML2S_INPUT_FORCE] = is_touched ? touch->z : 0,
    };
    if (!are_finite(values, ML2S_INPUT_COUNT)) {
        return error_set(error, ML2S_VENDOR_FAILURE, 0,
                         "MLInputGetControllerStateEx: trigger or touch is not a number, expected -1 to 1");
    }
    input->is_tracked = 1;
    memcpy(input->values, values, sizeof values);
    return ML2S_OK;
}

static ml2s_result poll_input(const ml2s_settings *, struct readings *readings, ml2s_error *error) {
    WITH_ROOM(MLInputControllerStateEx[MLInput_MaxControllers]) states;
    dump_begin(states.room);
    MLInputControllerStateExInit(states.of);
    ml2s_reading input;
    ml2s_result result = SDK_CALL(error, input, MLInputGetControllerStateEx, input_tracker, states.of);
    if (result) {
        return result;
    }
    DUMP_ONCE("MLInputControllerStateEx", states);
    if ((result = pose_begin(&input, ML2S_STREAM_CONTROLLER_JOY, error)) ||
        (states.of[0].is_connected && (result = copy_input(&states.of[0], &input, error)))) {
        return result;
    }
    readings_add(readings, &input);
    return ML2S_OK;
}

const struct source_ops source_controller_input = {
    .areas = 1u << SDK_INPUT | 1u << SDK_TIME, .open = begin_input, .poll_readings = poll_input, .close = end_input};
