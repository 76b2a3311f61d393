#include "snapshot.h"

#include <android/log.h>

#include "lock.h"

/** Many times what the vendor takes for a snapshot. */
#define RETURNED_WITHIN_MS 1000

static turn_t taken;

/** The result of the previous call, so that a change is logged once. */
static _Atomic MLResult last_code;

static void log_invalid_time(MLResult code) {
    if (code == MLResult_InvalidTimestamp && code != atomic_load(&last_code)) {
        __android_log_print(ANDROID_LOG_WARN, "ml2s",
                            "MLPerceptionGetPredictedSnapshot: InvalidTimestamp (%d): poses are those of the latest "
                            "snapshot, up to a display frame off their stamps",
                            code);
    }
    atomic_store(&last_code, code);
}

ml2s_result snapshot_take(MLTime time, struct snapshot *out, ml2s_error *error) {
    out->turn = turn_take_away(&taken, RETURNED_WITHIN_MS);
    const char *call = "MLPerceptionGetPredictedSnapshot";
    MLResult code = sdk.snapshot.MLPerceptionGetPredictedSnapshot(time, &out->of);
    log_invalid_time(code);
    if (code == MLResult_InvalidTimestamp) {
        call = "MLPerceptionGetSnapshot";
        code = sdk.perception.MLPerceptionGetSnapshot(&out->of);
    }
    if (code != MLResult_Ok) {
        turn_end(&taken, out->turn);
    }
    return result_of(code, call, error);
}

ml2s_result snapshot_release(struct snapshot snapshot, ml2s_result result, ml2s_error *error) {
    bool is_failure = result && result != ML2S_NO_POSE;
    ml2s_result released = SDK_CALL(is_failure ? NULL : error, perception, MLPerceptionReleaseSnapshot, snapshot.of);
    turn_end(&taken, snapshot.turn);
    return is_failure ? result : released;
}

MLResult snapshot_touch(void) {
    MLSnapshot *snapshot = NULL;
    uint32_t turn = turn_take_away(&taken, RETURNED_WITHIN_MS);
    MLResult result = sdk.perception.MLPerceptionGetSnapshot(&snapshot);
    if (result == MLResult_Ok) {
        result = sdk.perception.MLPerceptionReleaseSnapshot(snapshot);
    }
    turn_end(&taken, turn);
    return result;
}
