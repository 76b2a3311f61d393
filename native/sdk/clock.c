#include "clock.h"

#include "lock.h"
#include "tables.h"

#define SECOND_NANOS INT64_C(1000000000)

enum { READINGS = 5 };

static int64_t read_nanos(clockid_t clock) {
    struct timespec now;
    clock_gettime(clock, &now);
    return now.tv_sec * SECOND_NANOS + now.tv_nsec;
}

int64_t ml2s_now(void) { return read_nanos(CLOCK_BOOTTIME); }

/** CLOCK_BOOTTIME minus CLOCK_MONOTONIC: nanos, with an error of at most width_nanos / 2. */
struct offset {
    int64_t nanos;
    int64_t width_nanos;
};

static struct offset measure(void) {
    struct offset best = {0, INT64_MAX};
    for (int i = 0; i < READINGS; i++) {
        int64_t before = read_nanos(CLOCK_MONOTONIC);
        int64_t boottime = read_nanos(CLOCK_BOOTTIME);
        int64_t width = read_nanos(CLOCK_MONOTONIC) - before;
        if (width < best.width_nanos) {
            best = (struct offset){boottime - before - width / 2, width};
        }
    }
    return best;
}

static lock_t measuring = ATOMIC_FLAG_INIT;
static struct offset known = {0, -1};
static _Atomic int64_t offset_nanos;
static _Atomic int64_t measured_nanos = INT64_MIN / 2;

void clock_resample(void) {
    lock(&measuring);
    struct offset found = measure();
    int64_t moved = found.nanos - known.nanos;
    // Keep the first of two compatible measurements, so that captures of one instant get equal stamps.
    if (known.width_nanos < 0 || 2 * (moved < 0 ? -moved : moved) > found.width_nanos + known.width_nanos) {
        known = found;
        atomic_store(&offset_nanos, found.nanos);
    }
    atomic_store(&measured_nanos, read_nanos(CLOCK_MONOTONIC));
    unlock(&measuring);
}

int64_t clock_boottime_of_monotonic(int64_t monotonic_nanos) {
    if (read_nanos(CLOCK_MONOTONIC) - atomic_load(&measured_nanos) > SECOND_NANOS) {
        clock_resample();
    }
    return monotonic_nanos + atomic_load(&offset_nanos);
}

ml2s_result clock_boottime_of_mltime(MLTime time, int64_t *boottime_nanos, ml2s_error *error) {
    struct timespec monotonic;
    ml2s_result result = SDK_CALL(error, time, MLTimeConvertMLTimeToSystemTime, time, &monotonic);
    if (!result) {
        *boottime_nanos = clock_boottime_of_monotonic(monotonic.tv_sec * SECOND_NANOS + monotonic.tv_nsec);
    }
    return result;
}

ml2s_result clock_mltime_now(MLTime *now, ml2s_error *error) {
    struct timespec monotonic;
    clock_gettime(CLOCK_MONOTONIC, &monotonic);
    return SDK_CALL(error, time, MLTimeConvertSystemTimeToMLTime, &monotonic, now);
}

ml2s_result ml2s_boottime_of(int64_t device_nanos, int64_t *capture_nanos, ml2s_error *error) {
    if (!capture_nanos || (error && error->struct_size < sizeof *error)) {
        return ML2S_INVALID_ARGUMENT;
    }
    ml2s_result result = sdk_require(1u << SDK_TIME, error);
    return result ? result : clock_boottime_of_mltime(device_nanos, capture_nanos, error);
}
