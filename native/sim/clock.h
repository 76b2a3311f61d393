// The clocks of the simulated headset: MLTime and the system clocks, real or manual.
#pragma once

#include <cstdint>

namespace ml2sim {

constexpr int64_t kSecond = 1000000000;

int64_t monotonicNow();
int64_t mlTimeNow();
int64_t mlTimeOfMonotonic(int64_t nanos);
int64_t monotonicOfMlTime(int64_t nanos);

/** CLOCK_BOOTTIME is CLOCK_MONOTONIC plus the time that the machine has slept. */
int64_t mlTimeOfBoottime(int64_t nanos);
int64_t boottimeOfMlTime(int64_t nanos);

/** Advances the manual clock and wakes waiting threads. */
void advanceClock(int64_t nanos);

/** Sets the manual clock to its start. */
void resetClock();

/** Returns the number of wakeWaiters calls. Read it before the condition of a wait. */
uint64_t wakeCount();

/** Wakes waiting threads after a change of a key or the clock. */
void wakeWaiters();

/** Waits until MLTime is at least until, or wakeCount differs from seen. */
void waitUntil(int64_t until, uint64_t seen);

} // namespace ml2sim
