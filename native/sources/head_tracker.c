#include "head_tracker.h"

ml2s_result head_tracker_open(MLHandle *tracker, ml2s_error *error) {
    ml2s_result result = perception_start(error);
    if (result) {
        return result;
    }
    return perception_connected(SDK_CALL(error, head, MLHeadTrackingCreate, tracker), tracker);
}

ml2s_result head_tracker_accompanies(ml2s_result result, MLHandle *other, MLHandle *tracker) {
    if (result) {
        *other = ML_INVALID_HANDLE;
        head_tracker_close(tracker, NULL);
    }
    return result;
}

ml2s_result head_tracker_close(MLHandle *tracker, ml2s_error *error) {
    if (*tracker == ML_INVALID_HANDLE) {
        return ML2S_OK;
    }
    return perception_disconnected(SDK_CALL(error, head, MLHeadTrackingDestroy, *tracker), tracker, error);
}
