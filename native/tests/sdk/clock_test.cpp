#include <ctime>

#include <gtest/gtest.h>

extern "C" {
#include "../../sdk/clock.h"
}

namespace {

int64_t nanosOf(clockid_t clock) {
    timespec now;
    clock_gettime(clock, &now);
    return now.tv_sec * int64_t{1000000000} + now.tv_nsec;
}

} // namespace

TEST(Clock, BoottimeOfNowLiesBetweenTwoReadingsOfIt) {
    clock_boottime_of_monotonic(0); // Measures, which takes longer than the slack below.
    // Measuring is right to half the time that its own readings take.
    constexpr int64_t kSlack = 100000;
    const int64_t before = nanosOf(CLOCK_BOOTTIME);
    const int64_t now = clock_boottime_of_monotonic(nanosOf(CLOCK_MONOTONIC));
    EXPECT_GE(now, before - kSlack);
    EXPECT_LE(now, nanosOf(CLOCK_BOOTTIME) + kSlack);
}

TEST(Clock, EqualInstantsStayEqualWhenTheClocksAreMeasuredAgain) {
    const int64_t first = clock_boottime_of_monotonic(123456789);
    for (int i = 0; i < 1000; i++) {
        clock_resample();
        ASSERT_EQ(clock_boottime_of_monotonic(123456789), first);
    }
}

TEST(Clock, DifferencesAreKeptToTheNanosecond) {
    EXPECT_EQ(clock_boottime_of_monotonic(2000000001) - clock_boottime_of_monotonic(999999999), 1000000002);
}
