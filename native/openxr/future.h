/** Waiting for asynchronous calls. */
#pragma once

#include "xr_api.h"

/**
 * Waits until the future is ready, at most 5 s. call is the name of the asynchronous call, for the message. With
 * is_starting, the wait ends with the session; a sensor that stops is waited for, since the session lasts until then.
 */
ml2s_result future_wait(XrFutureEXT future, const char *call, bool is_starting, ml2s_error *error);
