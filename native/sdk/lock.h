/** A lock for calls that open and close sensors. The path of a frame takes no lock. */
#pragma once

#include <stdatomic.h>
#include <time.h>

typedef atomic_flag lock_t;

/** Sleeps 0.1 ms. A lock can be held for 2 s, the longest start of the perception system. */
static inline void await_another_thread(void) { nanosleep(&(struct timespec){.tv_nsec = 100000}, NULL); }

static inline void lock(lock_t *lock) {
    while (atomic_flag_test_and_set_explicit(lock, memory_order_acquire)) {
        await_another_thread();
    }
}

static inline void unlock(lock_t *lock) { atomic_flag_clear_explicit(lock, memory_order_release); }
