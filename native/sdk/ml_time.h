/**
 * Conversions between MLTime and CLOCK_MONOTONIC, without permission and startup. The vendor states neither that they
 * are equal nor that their difference is constant.
 */
#pragma once

#include <time.h>

#include "ml_types.h"

#define ML_TIME_FUNCTIONS(F)                                                                                           \
    F(MLTimeConvertMLTimeToSystemTime, (MLTime ml_time, struct timespec * out_monotonic))                              \
    F(MLTimeConvertSystemTimeToMLTime, (const struct timespec *monotonic, MLTime *out_ml_time))

ML_TIME_FUNCTIONS(ML_PROTOTYPE)

ML_SIZE(struct timespec, 16);
