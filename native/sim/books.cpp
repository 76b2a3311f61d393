#include "books.h"

#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <mutex>
#include <string>

#include "settings.h"

namespace ml2sim {
namespace {

std::mutex mutex;
ml2sim_book book{};

uint32_t &entry(Account account) {
    switch (account) {
    case Account::Handles:
        return book.open_handles;
    case Account::Gets:
        return book.outstanding_gets;
    case Account::Snapshots:
        return book.outstanding_snapshots;
    default:
        return book.outstanding_capability_lists;
    }
}

/** At the end of the process what is still open has leaked. */
struct Leaks {
    ~Leaks() {
        if (book.open_handles + book.outstanding_gets + book.outstanding_snapshots +
                book.outstanding_capability_lists ==
            0)
            return;
        std::fprintf(stderr, "ml2sim: left open: %u handles, %u gets, %u snapshots, %u capability lists\n",
                     book.open_handles, book.outstanding_gets, book.outstanding_snapshots,
                     book.outstanding_capability_lists);
    }
} leaks;

} // namespace

void enter(Account account, int32_t change) {
    const std::lock_guard lock(mutex);
    entry(account) += static_cast<uint32_t>(change);
}

void enterPerception(bool isStarted) {
    const std::lock_guard lock(mutex);
    book.is_perception_started = isStarted;
}

void misuse(ml2sim_misuse kind, const char *format, ...) {
    {
        const std::lock_guard lock(mutex);
        va_list values;
        va_start(values, format);
        std::vsnprintf(book.last_misuse, sizeof book.last_misuse, format, values);
        va_end(values);
        book.misuses[kind]++;
        std::fprintf(stderr, "ml2sim: misuse: %s\n", book.last_misuse);
    }
    if (isOn(Key::AbortOnMisuse))
        std::abort();
}

void resetBooks() {
    const std::lock_guard lock(mutex);
    book = {};
}

} // namespace ml2sim

void ml2sim_books(ml2sim_book *out) {
    const std::lock_guard lock(ml2sim::mutex);
    *out = ml2sim::book;
}
