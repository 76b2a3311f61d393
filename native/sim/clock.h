// Time of the simulated headset: MLTime and the system clocks it converts to, real or moved by hand.
#pragma once

#include <cstdint>

namespace ml2sim {

/** Nanoseconds since the seconds given, whole ones exactly. */
constexpr int64_t kSecond = 1000000000;

int64_t monotonicNow();
int64_t mlTimeNow();
int64_t mlTimeOfMonotonic(int64_t nanos);
int64_t monotonicOfMlTime(int64_t nanos);

/** CLOCK_BOOTTIME is CLOCK_MONOTONIC and the time that the machine slept. */
int64_t mlTimeOfBoottime(int64_t nanos);
int64_t boottimeOfMlTime(int64_t nanos);

/** Moves the manual clock and wakes who waits for it. */
void advanceClock(int64_t nanos);

/** The manual clock as it is at the start. */
void resetClock();

/** A number that changes with every wakeWaiters; to be taken before what a wait depends on is looked at. */
uint64_t wakeCount();

/** Lets everyone who waits look again, because a key or the clock has changed. */
void wakeWaiters();

/** Returns when MLTime has reached until, or wakeCount is no longer seen. */
void waitUntil(int64_t until, uint64_t seen);

} // namespace ml2sim
