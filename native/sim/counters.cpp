#include "counters.h"

#include <chrono>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <mutex>
#include <string>

#include "settings.h"

namespace ml2sim {
namespace {

std::mutex mutex;
ml2sim_counters counters{};

uint32_t &valueOf(Counter counter) {
    switch (counter) {
    case Counter::Handles:
        return counters.open_handles;
    case Counter::Gets:
        return counters.outstanding_gets;
    case Counter::Snapshots:
        return counters.outstanding_snapshots;
    default:
        return counters.outstanding_capability_lists;
    }
}

using Time = std::chrono::steady_clock::time_point;

/** The captures that a camera left out. */
struct LeftOut {
    int64_t sum = 0;
    int64_t said = 0;
    Time saidAt{};
};
std::map<std::string, LeftOut> leftOut;

void say(const std::string &camera, LeftOut &captures, Time now) {
    if (captures.said == captures.sum)
        return;
    std::fprintf(stderr, "ml2sim: %s camera: %lld captures left out so far, while frames were rendered\n",
                 camera.c_str(), static_cast<long long>(captures.sum));
    captures.said = captures.sum;
    captures.saidAt = now;
}

/** Reports what is still unsaid or open when the process ends. */
struct AtExit {
    ~AtExit() {
        for (auto &[camera, captures] : leftOut)
            say(camera, captures, {});
        if (counters.open_handles + counters.outstanding_gets + counters.outstanding_snapshots +
                counters.outstanding_capability_lists ==
            0)
            return;
        std::fprintf(stderr, "ml2sim: not released: %u handles, %u gets, %u snapshots, %u capability lists\n",
                     counters.open_handles, counters.outstanding_gets, counters.outstanding_snapshots,
                     counters.outstanding_capability_lists);
    }
} atExit;

} // namespace

void adjust(Counter counter, int32_t change) {
    const std::lock_guard lock(mutex);
    valueOf(counter) += static_cast<uint32_t>(change);
}

void setPerceptionStarted(bool isStarted) {
    const std::lock_guard lock(mutex);
    counters.is_perception_started = isStarted;
}

void countLeftOut(const char *camera, int64_t captures) {
    constexpr auto kPause = std::chrono::seconds(2);
    const auto now = std::chrono::steady_clock::now();
    if (captures <= 0)
        return;
    const std::lock_guard lock(mutex);
    auto &known = leftOut[camera];
    known.sum += captures;
    if (now - known.saidAt >= kPause)
        say(camera, known, now);
}

void misuse(ml2sim_misuse kind, const char *format, ...) {
    {
        const std::lock_guard lock(mutex);
        va_list values;
        va_start(values, format);
        std::vsnprintf(counters.last_misuse, sizeof counters.last_misuse, format, values);
        va_end(values);
        counters.misuses[kind]++;
        std::fprintf(stderr, "ml2sim: misuse: %s\n", counters.last_misuse);
    }
    if (isOn(Key::AbortOnMisuse))
        std::abort();
}

void resetCounters() {
    const std::lock_guard lock(mutex);
    counters = {};
    leftOut.clear();
}

} // namespace ml2sim

void ml2sim_get_counters(ml2sim_counters *out) {
    const std::lock_guard lock(ml2sim::mutex);
    *out = ml2sim::counters;
}

uint64_t ml2sim_captures_left_out(void) {
    const std::lock_guard lock(ml2sim::mutex);
    uint64_t sum = 0;
    for (const auto &camera : ml2sim::leftOut)
        sum += static_cast<uint64_t>(camera.second.sum);
    return sum;
}
