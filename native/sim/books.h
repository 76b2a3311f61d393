// What is open and what was done wrong: the books of ml2sim_books.
#pragma once

#include <cstdint>

#include "ml2sim.h"

namespace ml2sim {

enum class Account { Handles, Gets, Snapshots, CapabilityLists };

/** Enters one more or one less. Any thread. */
void enter(Account account, int32_t change);

void enterPerception(bool isStarted);

/** Counts a misuse, tells it on stderr, and aborts if the key says so. The format is printf's. */
void misuse(ml2sim_misuse kind, const char *format, ...) __attribute__((format(printf, 2, 3)));

void resetBooks();

} // namespace ml2sim
