#include "head_tracker.h"

ml2s_result head_tracker_open(MLHandle *tracker, ml2s_error *error) {
    ml2s_result result = perception_start(error);
    if (result) {
        return result;
    }
    result = SDK_CALL(error, head, MLHeadTrackingCreate, tracker);
    if (result) {
        *tracker = ML_INVALID_HANDLE;
        perception_stop(NULL);
    }
    return result;
}

ml2s_result head_tracker_close(MLHandle *tracker, ml2s_error *error) {
    if (*tracker == ML_INVALID_HANDLE) {
        return ML2S_OK;
    }
    ml2s_result result = SDK_CALL(error, head, MLHeadTrackingDestroy, *tracker);
    *tracker = ML_INVALID_HANDLE;
    ml2s_result stopped = perception_stop(result ? NULL : error);
    return result ? result : stopped;
}
