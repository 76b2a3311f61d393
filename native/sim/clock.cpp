#include "clock.h"

#include <atomic>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <ctime>
#include <mutex>

#include "settings.h"

namespace ml2sim {
namespace {

/** Start of the manual clock, far from 0, so that a missing offset is noticed. */
constexpr int64_t kManualStart = 1000 * kSecond;

std::atomic<int64_t> manualNanos{kManualStart};
std::mutex mutex;
std::condition_variable changed;
uint64_t wakes = 0;

bool isManual() { return text(Key::Clock) == "manual"; }

int64_t read(clockid_t clock) {
    timespec now{};
    clock_gettime(clock, &now);
    return now.tv_sec * kSecond + now.tv_nsec;
}

/** Returns the time that the machine has slept. Only a real sleep changes it, so that equal times stay equal. */
int64_t sleptNanos() {
    static std::atomic<int64_t> known{0};
    const int64_t before = read(CLOCK_MONOTONIC);
    const int64_t boottime = read(CLOCK_BOOTTIME);
    const int64_t after = read(CLOCK_MONOTONIC);
    const int64_t slept = boottime - (before + (after - before) / 2);
    if (after - before < kSecond / 1000 && std::abs(slept - known) > kSecond / 1000)
        known = slept;
    return known;
}

int64_t offset() { return std::llround(number(Key::MlTimeOffset) * kSecond); }

/** In parts per billion, so that products are exact in 128 bits. */
__int128 skewPpb() { return std::llround(number(Key::MlTimeSkew) * 1000); }

} // namespace

int64_t monotonicNow() { return isManual() ? manualNanos.load() : read(CLOCK_MONOTONIC); }

int64_t mlTimeNow() { return mlTimeOfMonotonic(monotonicNow()); }

int64_t mlTimeOfMonotonic(int64_t nanos) {
    return offset() + nanos + static_cast<int64_t>(skewPpb() * nanos / kSecond);
}

int64_t monotonicOfMlTime(int64_t nanos) {
    return static_cast<int64_t>(static_cast<__int128>(nanos - offset()) * kSecond / (kSecond + skewPpb()));
}

int64_t mlTimeOfBoottime(int64_t nanos) { return mlTimeOfMonotonic(nanos - sleptNanos()); }

int64_t boottimeOfMlTime(int64_t nanos) { return monotonicOfMlTime(nanos) + sleptNanos(); }

void advanceClock(int64_t nanos) {
    manualNanos += nanos;
    wakeWaiters();
}

void resetClock() { manualNanos = kManualStart; }

uint64_t wakeCount() {
    const std::lock_guard lock(mutex);
    return wakes;
}

void wakeWaiters() {
    {
        const std::lock_guard lock(mutex);
        wakes++;
    }
    changed.notify_all();
}

void waitUntil(int64_t until, uint64_t seen) {
    const int64_t rest = until - mlTimeNow();
    if (rest <= 0)
        return;
    std::unique_lock lock(mutex);
    const auto isWoken = [seen] { return wakes != seen; };
    if (isManual())
        changed.wait(lock, isWoken);
    else
        changed.wait_for(lock, std::chrono::nanoseconds(rest), isWoken);
}

} // namespace ml2sim
