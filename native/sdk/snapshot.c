#include "snapshot.h"

#include <android/log.h>

#include "lock.h"

static lock_t taken = ATOMIC_FLAG_INIT;

/** The result of the previous call, so that a change is logged once. */
static MLResult last_code;

static void log_invalid_time(MLResult code) {
    if (code == MLResult_InvalidTimestamp && code != last_code) {
        __android_log_print(ANDROID_LOG_WARN, "ml2s",
                            "MLPerceptionGetPredictedSnapshot: InvalidTimestamp (%d): poses are those of the latest "
                            "snapshot, up to a display frame off their stamps",
                            code);
    }
    last_code = code;
}

ml2s_result snapshot_take(MLTime time, MLSnapshot **out, ml2s_error *error) {
    lock(&taken);
    const char *call = "MLPerceptionGetPredictedSnapshot";
    MLResult code = sdk.snapshot.MLPerceptionGetPredictedSnapshot(time, out);
    log_invalid_time(code);
    if (code == MLResult_InvalidTimestamp) {
        call = "MLPerceptionGetSnapshot";
        code = sdk.perception.MLPerceptionGetSnapshot(out);
    }
    if (code != MLResult_Ok) {
        unlock(&taken);
    }
    return result_of(code, call, error);
}

ml2s_result snapshot_release(MLSnapshot *snapshot, ml2s_result result, ml2s_error *error) {
    bool is_failure = result && result != ML2S_NO_POSE;
    ml2s_result released = SDK_CALL(is_failure ? NULL : error, perception, MLPerceptionReleaseSnapshot, snapshot);
    unlock(&taken);
    return is_failure ? result : released;
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
