#include "counters.h"

#include <cstdarg>
#include <cstdio>
#include <cstdlib>
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

/** Reports what is still open when the process ends. */
struct Leaks {
    ~Leaks() {
        if (counters.open_handles + counters.outstanding_gets + counters.outstanding_snapshots +
                counters.outstanding_capability_lists ==
            0)
            return;
        std::fprintf(stderr, "ml2sim: not released: %u handles, %u gets, %u snapshots, %u capability lists\n",
                     counters.open_handles, counters.outstanding_gets, counters.outstanding_snapshots,
                     counters.outstanding_capability_lists);
    }
} leaks;

} // namespace

void adjust(Counter counter, int32_t change) {
    const std::lock_guard lock(mutex);
    valueOf(counter) += static_cast<uint32_t>(change);
}

void setPerceptionStarted(bool isStarted) {
    const std::lock_guard lock(mutex);
    counters.is_perception_started = isStarted;
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
}

} // namespace ml2sim

void ml2sim_get_counters(ml2sim_counters *out) {
    const std::lock_guard lock(ml2sim::mutex);
    *out = ml2sim::counters;
}
