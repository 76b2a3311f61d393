/** Device times and CLOCK_BOOTTIME. Any thread; needs the area SDK_TIME of perception.h where MLTime occurs. */
#pragma once

#include "ml2s.h"
#include "ml_time.h"

/**
 * The CLOCK_BOOTTIME instant of one of CLOCK_MONOTONIC, both in nanoseconds. They differ by the time that the device
 * slept, which is measured again every second and by clock_resample; in between, equal inputs give equal outputs.
 */
int64_t clock_boottime_of_monotonic(int64_t monotonic_nanos);

/** After the device may have slept. */
void clock_resample(void);

ml2s_result clock_boottime_of_mltime(MLTime time, int64_t *boottime_nanos, ml2s_error *error);

ml2s_result clock_mltime_now(MLTime *now, ml2s_error *error);
