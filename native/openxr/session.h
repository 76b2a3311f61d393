/** A headless session of the library's own instance, following the states that the runtime gives it. */
#pragma once

#include "xr_api.h"

/** Needs xr.system. Waits until the session runs; a failure leaves none. */
ml2s_result session_create(ml2s_error *error);

ml2s_result session_destroy(ml2s_error *error);

/** Does what the runtime's events ask for, from any thread; fails once the session is lost. */
ml2s_result session_handle_events(ml2s_error *error);

/** Whether the origin of xr.world has moved since the last call. */
bool session_world_moved(void);
