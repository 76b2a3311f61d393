/** The headless session of the library's own instance. */
#pragma once

#include "xr_api.h"

/** Creates the session and waits until it runs. Needs xr.system. After a failure there is no session. */
ml2s_result session_create(ml2s_error *error);

ml2s_result session_destroy(ml2s_error *error);

/** Handles the events of the runtime. Fails after the session was lost. Thread-safe. */
ml2s_result session_handle_events(ml2s_error *error);

/** Returns true if the origin of xr.world has moved since the last call. */
bool session_world_moved(void);
