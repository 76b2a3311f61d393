/** Waiting for what an asynchronous call began. */
#pragma once

#include "xr_api.h"

/** A millisecond. */
void sleep_millisecond(void);

/** Until future can be completed; call names what began it. */
ml2s_result future_wait(XrFutureEXT future, const char *call, ml2s_error *error);
