/** Asynchronous calls of the runtime. Cancel a future that is not completed, unless its object is destroyed. */
#pragma once

#include "xr_api.h"

/** Returns whether the call is ready to be completed. Does not block. */
ml2s_result future_poll(XrFutureEXT future, bool *is_ready, ml2s_error *error);

/** Cancels the call. The future is invalid afterwards. */
ml2s_result future_cancel(XrFutureEXT future, ml2s_error *error);

/**
 * Waits until the future is ready, at most 5 s, and else cancels it. call is the name of the asynchronous call, for the
 * message. With is_starting, the wait ends with the session; a sensor that stops is waited for, since the session lasts
 * until then. Only for sensors whose thread has nothing else to do.
 */
ml2s_result future_wait(XrFutureEXT future, const char *call, bool is_starting, ml2s_error *error);

/**
 * Calls nameAsyncML of the pixel sensors, waits as future_wait, and calls nameCompleteML, which writes completion.
 * Returns the first failure.
 */
#define XR_COMPLETE(error, name, sensor, info, completion, is_starting)                                                \
    ({                                                                                                                 \
        XrFutureEXT future;                                                                                            \
        ml2s_result result = XR_CALL(error, pixel, name##AsyncML, sensor, info, &future);                              \
        result = result ? result : future_wait(future, #name "AsyncML", is_starting, error);                           \
        result = result ? result : XR_CALL(error, pixel, name##CompleteML, sensor, future, completion);                \
        result ? result : xr_result_of((completion)->futureResult, #name "AsyncML", error);                            \
    })
