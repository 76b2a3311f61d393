#include "actions.h"

#include <string.h>

#include "../sdk/error.h"

#define HANDS(path)                                                                                                    \
    { "/user/hand/left" path, "/user/hand/right" path }

enum { MOST_BINDINGS = 2, PROFILE_COUNT = 2 };

static const struct {
    const char *name, *title;
    XrActionType type;
    const char *bindings[MOST_BINDINGS];
} known[ACTION_COUNT] = {
    [ACTION_GAZE] = {"gaze", "Gaze", XR_ACTION_TYPE_POSE_INPUT, {"/user/eyes_ext/input/gaze_ext/pose"}},
    [ACTION_CONTROLLER] = {"controller", "Controller", XR_ACTION_TYPE_POSE_INPUT, HANDS("/input/grip/pose")},
    [ACTION_TRIGGER] = {"trigger", "Trigger", XR_ACTION_TYPE_FLOAT_INPUT, HANDS("/input/trigger/value")},
    [ACTION_BUMPER] = {"bumper", "Bumper", XR_ACTION_TYPE_BOOLEAN_INPUT, HANDS("/input/shoulder/click")},
    [ACTION_MENU] = {"menu", "Menu", XR_ACTION_TYPE_BOOLEAN_INPUT, HANDS("/input/menu/click")},
    [ACTION_TOUCH] = {"touch", "Touch", XR_ACTION_TYPE_BOOLEAN_INPUT, HANDS("/input/trackpad/touch")},
    [ACTION_TOUCH_X] = {"touch_x", "Touch x", XR_ACTION_TYPE_FLOAT_INPUT, HANDS("/input/trackpad/x")},
    [ACTION_TOUCH_Y] = {"touch_y", "Touch y", XR_ACTION_TYPE_FLOAT_INPUT, HANDS("/input/trackpad/y")},
    [ACTION_FORCE] = {"force", "Force", XR_ACTION_TYPE_FLOAT_INPUT, HANDS("/input/trackpad/force")},
};

/** Interaction profiles with the actions that they bind: from first up to, not including, end. */
static const struct {
    const char *path;
    enum xr_area area;
    uint32_t first, end;
} profiles[PROFILE_COUNT] = {
    {"/interaction_profiles/ext/eye_gaze_interaction", XR_GAZE, ACTION_GAZE, ACTION_CONTROLLER},
    {"/interaction_profiles/ml/ml2_controller", XR_CONTROLLER, ACTION_CONTROLLER, ACTION_COUNT},
};

static turn_t attaching;
static bool is_attached;
static XrActionSet set;
static XrAction actions[ACTION_COUNT];

/** The refusals of profiles by the runtime. The other profiles work. */
static struct {
    ml2s_result result;
    ml2s_error error;
} refusals[PROFILE_COUNT];

static ml2s_result create(ml2s_error *error) {
    XrActionSetCreateInfo info = {
        .type = XR_TYPE_ACTION_SET_CREATE_INFO, .actionSetName = "sensors", .localizedActionSetName = "Sensors"};
    ml2s_result result = XR_CALL(error, core, xrCreateActionSet, xr.instance, &info, &set);
    for (uint32_t i = 0; i < ACTION_COUNT && !result; i++) {
        XrActionCreateInfo action = {.type = XR_TYPE_ACTION_CREATE_INFO, .actionType = known[i].type};
        memcpy(action.actionName, known[i].name, strlen(known[i].name));
        memcpy(action.localizedActionName, known[i].title, strlen(known[i].title));
        result = XR_CALL(error, core, xrCreateAction, set, &action, &actions[i]);
    }
    return result;
}

static ml2s_result suggest(const char *path, uint32_t first, uint32_t end, ml2s_error *error) {
    XrPath profile;
    XrActionSuggestedBinding bindings[ACTION_COUNT * MOST_BINDINGS];
    uint32_t count = 0;
    ml2s_result result = XR_CALL(error, core, xrStringToPath, xr.instance, path, &profile);
    for (uint32_t i = first; i < end; i++) {
        for (uint32_t k = 0; k < MOST_BINDINGS && known[i].bindings[k] && !result; k++) {
            bindings[count].action = actions[i];
            result =
                XR_CALL(error, core, xrStringToPath, xr.instance, known[i].bindings[k], &bindings[count++].binding);
        }
    }
    XrInteractionProfileSuggestedBinding suggestion = {XR_TYPE_INTERACTION_PROFILE_SUGGESTED_BINDING, NULL, profile,
                                                       count, bindings};
    return result ? result : XR_CALL(error, core, xrSuggestInteractionProfileBindings, xr.instance, &suggestion);
}

static ml2s_result attach(ml2s_error *error) {
    ml2s_result result = create(error);
    for (uint32_t i = 0; i < PROFILE_COUNT && !result; i++) {
        refusals[i].error = (ml2s_error){.struct_size = sizeof(ml2s_error)};
        refusals[i].result = xr.areas & XR_AREA_BIT(profiles[i].area)
                                 ? suggest(profiles[i].path, profiles[i].first, profiles[i].end, &refusals[i].error)
                                 : ML2S_OK;
    }
    XrSessionActionSetsAttachInfo info = {XR_TYPE_SESSION_ACTION_SETS_ATTACH_INFO, NULL, 1, &set};
    return result ? result : XR_CALL(error, core, xrAttachSessionActionSets, xr.session, &info);
}

static ml2s_result require_profile(enum action action, ml2s_error *error) {
    for (uint32_t i = 0; i < PROFILE_COUNT; i++) {
        if (action >= profiles[i].first && action < profiles[i].end && refusals[i].result) {
            const ml2s_error *reason = &refusals[i].error;
            return error_set(error, refusals[i].result, reason->vendor_code, "%s", reason->message);
        }
    }
    return ML2S_OK;
}

ml2s_result actions_attach(enum action action, const char *name, ml2s_error *error) {
    if (xr.is_borrowed) {
        return error_set(error, ML2S_NOT_AVAILABLE, 0,
                         "not available: %s in the app's session (attaching action sets would break the app's)", name);
    }
    uint32_t turn = xr_take_turn(&attaching, error);
    if (!turn) {
        return ML2S_VENDOR_FAILURE;
    }
    ml2s_result result = is_attached ? ML2S_OK : attach(error);
    is_attached = !result;
    if (result) {
        actions_destroy(NULL);
    }
    result = result ? result : require_profile(action, error);
    turn_end(&attaching, turn);
    return result;
}

ml2s_result actions_destroy(ml2s_error *error) {
    ml2s_result first = ML2S_OK;
    for (uint32_t i = 0; i < ACTION_COUNT; i++) {
        if (actions[i]) {
            ml2s_result result = XR_CALL(first ? NULL : error, core, xrDestroyAction, actions[i]);
            first = first ? first : result;
            actions[i] = XR_NULL_HANDLE;
        }
    }
    if (set) {
        ml2s_result result = XR_CALL(first ? NULL : error, core, xrDestroyActionSet, set);
        first = first ? first : result;
        set = XR_NULL_HANDLE;
    }
    is_attached = false;
    return first;
}

ml2s_result actions_sync(ml2s_error *error) {
    XrActiveActionSet active = {set, XR_NULL_PATH};
    XrActionsSyncInfo info = {XR_TYPE_ACTIONS_SYNC_INFO, NULL, 1, &active};
    return XR_CALL(error, core, xrSyncActions, xr.session, &info);
}

ml2s_result actions_create_space(enum action action, XrSpace *space, ml2s_error *error) {
    XrActionSpaceCreateInfo info = {.type = XR_TYPE_ACTION_SPACE_CREATE_INFO,
                                    .action = actions[action],
                                    .poseInActionSpace = {{0, 0, 0, 1}, {0, 0, 0}}};
    return XR_CALL(error, core, xrCreateActionSpace, xr.session, &info, space);
}

ml2s_result actions_get_bool(enum action action, XrActionStateBoolean *state, ml2s_error *error) {
    XrActionStateGetInfo info = {XR_TYPE_ACTION_STATE_GET_INFO, NULL, actions[action], XR_NULL_PATH};
    *state = (XrActionStateBoolean){.type = XR_TYPE_ACTION_STATE_BOOLEAN};
    return XR_CALL(error, core, xrGetActionStateBoolean, xr.session, &info, state);
}

ml2s_result actions_get_float(enum action action, float *value, ml2s_error *error) {
    XrActionStateGetInfo info = {XR_TYPE_ACTION_STATE_GET_INFO, NULL, actions[action], XR_NULL_PATH};
    XrActionStateFloat state = {.type = XR_TYPE_ACTION_STATE_FLOAT};
    ml2s_result result = XR_CALL(error, core, xrGetActionStateFloat, xr.session, &info, &state);
    *value = state.isActive ? state.currentState : 0;
    return result;
}
