// The counters of ml2sim_get_counters: open resources and misuses of the vendor's interface.
#pragma once

#include <cstdint>

#include "ml2sim.h"

namespace ml2sim {

enum class Counter { Handles, Gets, Snapshots, CapabilityLists };

/** Adds change to a counter. Thread-safe. */
void adjust(Counter counter, int32_t change);

void setPerceptionStarted(bool isStarted);

/** Counts captures that a camera left out, and writes the sum to stderr every few seconds. Thread-safe. */
void countLeftOut(const char *camera, int64_t captures);

/** Counts a misuse and writes it to stderr; aborts if the key abort_on_misuse is set. The format is printf's. */
void misuse(ml2sim_misuse kind, const char *format, ...) __attribute__((format(printf, 2, 3)));

void resetCounters();

} // namespace ml2sim
