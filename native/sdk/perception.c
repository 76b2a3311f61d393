#include "perception.h"

#include "error.h"
#include "lock.h"
#include "snapshot.h"

/** Longer than await_snapshot waits. */
#define STARTED_WITHIN_MS 3000

static turn_t starting;

static void await_snapshot(void) {
    enum { MOST_WAITS = 200 };
    const struct timespec wait = {.tv_nsec = 10000000};
    for (int i = 0; i < MOST_WAITS && snapshot_touch() != MLResult_Ok; i++) {
        nanosleep(&wait, NULL);
    }
}

static ml2s_result start_ours(ml2s_error *error) {
    MLPerceptionSettings settings;
    ml2s_result result;
    if ((result = SDK_CALL(error, perception, MLPerceptionInitSettings, &settings)) ||
        (result = SDK_CALL(error, perception, MLPerceptionStartup, &settings))) {
        return result;
    }
    await_snapshot();
    return ML2S_OK;
}

/** Checks each time, since an app that started the system may have shut it down. */
static ml2s_result start(ml2s_error *error) {
    MLResult running = snapshot_touch();
    return running == MLResult_PerceptionSystemNotStarted ? start_ours(error)
                                                          : result_of(running, "MLPerceptionGetSnapshot", error);
}

ml2s_result perception_start(ml2s_error *error) {
    uint32_t turn = turn_take(&starting, STARTED_WITHIN_MS);
    if (!turn) {
        return error_set(error, ML2S_VENDOR_FAILURE, 0, "MLPerceptionStartup has not returned to another sensor");
    }
    ml2s_result result = start(error);
    turn_end(&starting, turn);
    return result;
}
