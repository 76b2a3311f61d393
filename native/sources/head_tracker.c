#include "head_tracker.h"

ml2s_result head_tracker_open(MLHandle *tracker, ml2s_error *error) {
    ml2s_result result = perception_start(error);
    return result ? result : SDK_CALL(error, head, MLHeadTrackingCreate, tracker);
}

ml2s_result head_tracker_close_on_failure(ml2s_result result, MLHandle tracker) {
    if (result) {
        head_tracker_close(tracker, NULL);
    }
    return result;
}

ml2s_result head_tracker_close_after(ml2s_result result, MLHandle tracker, ml2s_error *error) {
    ml2s_result closed = head_tracker_close(tracker, result ? NULL : error);
    return result ? result : closed;
}

ml2s_result head_tracker_close(MLHandle tracker, ml2s_error *error) {
    return SDK_CALL(error, head, MLHeadTrackingDestroy, tracker);
}
