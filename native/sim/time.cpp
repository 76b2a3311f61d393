// MLTimeConvert*: MLTime and CLOCK_MONOTONIC.
#include "ml_time.h"

#include "camera_connection.h"
#include "clock.h"

using namespace ml2sim;

MLResult MLTimeConvertMLTimeToSystemTime(MLTime ml_time, struct timespec *out_monotonic) {
    passHold(__func__);
    if (out_monotonic == nullptr)
        return refuseArgument(__func__, "out_monotonic is null");
    if (isOn(Key::FaultTimeConvert))
        return MLResult_UnspecifiedFailure;
    const int64_t nanos = monotonicOfMlTime(ml_time);
    if (nanos < 0)
        return refuseArgument(__func__, "ml_time is before CLOCK_MONOTONIC began");
    *out_monotonic = {nanos / kSecond, nanos % kSecond};
    return MLResult_Ok;
}

MLResult MLTimeConvertSystemTimeToMLTime(const struct timespec *monotonic, MLTime *out_ml_time) {
    passHold(__func__);
    if (monotonic == nullptr || out_ml_time == nullptr)
        return refuseArgument(__func__, "monotonic or out_ml_time is null");
    if (monotonic->tv_nsec < 0 || monotonic->tv_nsec >= kSecond)
        return refuseArgument(__func__, "tv_nsec is not from 0 to 999999999");
    if (isOn(Key::FaultTimeConvert))
        return MLResult_UnspecifiedFailure;
    *out_ml_time = mlTimeOfMonotonic(monotonic->tv_sec * kSecond + monotonic->tv_nsec);
    return MLResult_Ok;
}
