/** Conversions between MLTime, CLOCK_MONOTONIC and CLOCK_BOOTTIME. Thread-safe. MLTime needs the area SDK_TIME. */
#pragma once

#include "ml2s.h"
#include "ml_time.h"

/**
 * Converts CLOCK_MONOTONIC to CLOCK_BOOTTIME, both in nanoseconds. They differ by the time that the device has slept,
 * which is measured every second and by clock_resample. Between measurements equal inputs give equal outputs.
 */
int64_t clock_boottime_of_monotonic(int64_t monotonic_nanos);

/** Measures the difference of the clocks. Call it when the device may have slept. */
void clock_resample(void);

ml2s_result clock_boottime_of_mltime(MLTime time, int64_t *boottime_nanos, ml2s_error *error);

ml2s_result clock_mltime_now(MLTime *now, ml2s_error *error);
