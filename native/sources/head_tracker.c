#include "head_tracker.h"

ml2s_result head_tracker_open(MLHandle *tracker, ml2s_error *error) {
    ml2s_result result = perception_start(error);
    if (result || (result = SDK_CALL(error, head, MLHeadTrackingCreate, tracker))) {
        *tracker = ML_INVALID_HANDLE;
    }
    return result;
}

ml2s_result head_tracker_close_on_failure(ml2s_result result, MLHandle *other, MLHandle *tracker) {
    if (result) {
        *other = ML_INVALID_HANDLE;
        head_tracker_close(tracker, NULL);
    }
    return result;
}

ml2s_result head_tracker_close_after(ml2s_result result, MLHandle *other, MLHandle *tracker, ml2s_error *error) {
    *other = ML_INVALID_HANDLE;
    ml2s_result closed = head_tracker_close(tracker, result ? NULL : error);
    return result ? result : closed;
}

ml2s_result head_tracker_close(MLHandle *tracker, ml2s_error *error) {
    ml2s_result result = SDK_CALL(error, head, MLHeadTrackingDestroy, *tracker);
    *tracker = ML_INVALID_HANDLE;
    return result;
}
