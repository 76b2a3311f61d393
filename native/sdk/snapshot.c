#include "snapshot.h"

#include "lock.h"

static lock_t taken = ATOMIC_FLAG_INIT;

ml2s_result snapshot_take(MLTime time, MLSnapshot **out, MLResult *code, ml2s_error *error) {
    lock(&taken);
    *code = sdk.snapshot.MLPerceptionGetPredictedSnapshot(time, out);
    const char *call = "MLPerceptionGetPredictedSnapshot";
    MLResult result = *code;
    if (result == MLResult_InvalidTimestamp) {
        call = "MLPerceptionGetSnapshot";
        result = sdk.perception.MLPerceptionGetSnapshot(out);
    }
    if (result != MLResult_Ok) {
        unlock(&taken);
    }
    return result_of(result, call, error);
}

ml2s_result snapshot_release(MLSnapshot *snapshot, ml2s_error *error) {
    ml2s_result result = SDK_CALL(error, perception, MLPerceptionReleaseSnapshot, snapshot);
    unlock(&taken);
    return result;
}

MLResult snapshot_touch(void) {
    MLSnapshot *snapshot = NULL;
    lock(&taken);
    MLResult result = sdk.perception.MLPerceptionGetSnapshot(&snapshot);
    if (result == MLResult_Ok) {
        result = sdk.perception.MLPerceptionReleaseSnapshot(snapshot);
    }
    unlock(&taken);
    return result;
}
