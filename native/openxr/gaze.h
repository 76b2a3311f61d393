/** The gaze action of the library's own session. */
#pragma once

#include "../sdk/ml2s.h"

/** Destroys the action set, action and space. Call it before the session is destroyed. */
ml2s_result gaze_destroy(ml2s_error *error);
