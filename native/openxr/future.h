/** Waiting for asynchronous calls. */
#pragma once

#include "xr_api.h"

/** Sleeps 1 ms. */
void sleep_millisecond(void);

/** Waits until the future is ready, at most 5 s. call is the name of the asynchronous call, for the message. */
ml2s_result future_wait(XrFutureEXT future, const char *call, ml2s_error *error);
