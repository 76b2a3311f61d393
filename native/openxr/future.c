#include "future.h"

#include "../sdk/error.h"
#include "runtime.h"

#define READY_WITHIN_NANOS INT64_C(5000000000)

ml2s_result future_wait(XrFutureEXT future, const char *call, bool is_starting, ml2s_error *error) {
    for (int64_t until = ml2s_now() + READY_WITHIN_NANOS; ml2s_now() < until; sleep_millisecond()) {
        XrFuturePollInfoEXT info = {XR_TYPE_FUTURE_POLL_INFO_EXT, NULL, future};
        XrFuturePollResultEXT polled = {.type = XR_TYPE_FUTURE_POLL_RESULT_EXT};
        ml2s_result result = XR_CALL(error, future, xrPollFutureEXT, xr.instance, &info, &polled);
        if (result || polled.state == XR_FUTURE_STATE_READY_EXT ||
            (is_starting && (result = xr_handle_events(error)))) {
            return result;
        }
    }
    return error_set(error, ML2S_VENDOR_FAILURE, 0, "%s: not completed within 5 s", call);
}
