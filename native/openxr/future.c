#include "future.h"

#include "../sdk/error.h"
#include "runtime.h"

#define READY_WITHIN_NANOS INT64_C(5000000000)

ml2s_result future_poll(XrFutureEXT future, bool *is_ready, ml2s_error *error) {
    XrFuturePollInfoEXT info = {XR_TYPE_FUTURE_POLL_INFO_EXT, NULL, future};
    XrFuturePollResultEXT polled = {.type = XR_TYPE_FUTURE_POLL_RESULT_EXT};
    ml2s_result result = XR_CALL(error, future, xrPollFutureEXT, xr.instance, &info, &polled);
    *is_ready = !result && polled.state == XR_FUTURE_STATE_READY_EXT;
    return result;
}

ml2s_result future_cancel(XrFutureEXT future, ml2s_error *error) {
    XrFutureCancelInfoEXT info = {XR_TYPE_FUTURE_CANCEL_INFO_EXT, NULL, future};
    return XR_CALL(error, future, xrCancelFutureEXT, xr.instance, &info);
}

ml2s_result future_wait(XrFutureEXT future, const char *call, bool is_starting, ml2s_error *error) {
    for (int64_t until = ml2s_now() + READY_WITHIN_NANOS; ml2s_now() < until; sleep_millisecond()) {
        bool is_ready;
        ml2s_result result = future_poll(future, &is_ready, error);
        if (result || is_ready) {
            return result;
        }
        if (is_starting && (result = xr_handle_events(error))) {
            future_cancel(future, NULL);
            return result;
        }
    }
    future_cancel(future, NULL);
    return error_set(error, ML2S_VENDOR_FAILURE, 0, "%s: not completed within 5 s", call);
}
