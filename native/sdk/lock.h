/** A lock for the rare calls that open and close things; nothing on a frame's way takes one. */
#pragma once

#include <stdatomic.h>
#include <time.h>

typedef atomic_flag lock_t;

/** Lets another thread go on; some of these waits last 2 s, as long as a start of the perception system. */
static inline void await_another_thread(void) { nanosleep(&(struct timespec){.tv_nsec = 100000}, NULL); }

static inline void lock(lock_t *lock) {
    while (atomic_flag_test_and_set_explicit(lock, memory_order_acquire)) {
        await_another_thread();
    }
}

static inline void unlock(lock_t *lock) { atomic_flag_clear_explicit(lock, memory_order_release); }
