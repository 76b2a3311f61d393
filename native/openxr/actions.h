/**
 * The actions of the library's own session. OpenXR attaches action sets once per session, so gaze and controller share
 * one set, which lives as long as the session. Thread-safe.
 */
#pragma once

#include "xr_api.h"

enum action {
    ACTION_GAZE,
    ACTION_CONTROLLER,
    ACTION_TRIGGER,
    ACTION_BUMPER,
    ACTION_MENU,
    ACTION_TOUCH,
    ACTION_TOUCH_X,
    ACTION_TOUCH_Y,
    ACTION_FORCE,
    ACTION_COUNT,
};

/**
 * Creates the actions, suggests a binding for each whose extension is enabled, and attaches them, unless that has
 * happened. Returns ML2S_NOT_AVAILABLE in an app's session, where attaching would break the app's actions; name is what
 * the message calls the sensor. Fails if the runtime refused the bindings of action; other actions work. After another
 * failure the next call tries again.
 */
ml2s_result actions_attach(enum action action, const char *name, ml2s_error *error);

/** Destroys the actions. Call it before the session is destroyed. */
ml2s_result actions_destroy(ml2s_error *error);

/** Updates the state of all actions. */
ml2s_result actions_sync(ml2s_error *error);

/** Creates the space of an action of type pose. */
ml2s_result actions_create_space(enum action action, XrSpace *space, ml2s_error *error);

/** Return the state of an action, which is 0 while nothing is bound to it. */
ml2s_result actions_get_bool(enum action action, XrActionStateBoolean *state, ml2s_error *error);
ml2s_result actions_get_float(enum action action, float *value, ml2s_error *error);
