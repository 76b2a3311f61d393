/** A lock for the rare calls that open and close things; nothing on a frame's way takes one. */
#pragma once

#include <sched.h>
#include <stdatomic.h>

typedef atomic_flag lock_t;

static inline void lock(lock_t *lock) {
    while (atomic_flag_test_and_set_explicit(lock, memory_order_acquire)) {
        sched_yield();
    }
}

static inline void unlock(lock_t *lock) { atomic_flag_clear_explicit(lock, memory_order_release); }
