/**
 * Locks and turns for calls that open and close sensors. The path of a frame takes none.
 *
 * A lock is never held while the vendor is called, who may not return. A turn is what threads take one after another at
 * a part of the vendor's library that only one of them may use: nobody waits for it without a limit.
 */
#pragma once

#include <stdatomic.h>
#include <stdint.h>
#include <time.h>

typedef atomic_flag lock_t;

/** Sleeps 0.1 ms. */
static inline void await_another_thread(void) { nanosleep(&(struct timespec){.tv_nsec = 100000}, NULL); }

static inline void lock(lock_t *lock) {
    while (atomic_flag_test_and_set_explicit(lock, memory_order_acquire)) {
        await_another_thread();
    }
}

static inline void unlock(lock_t *lock) { atomic_flag_clear_explicit(lock, memory_order_release); }

/** Zeroed while nobody has it. */
typedef struct {
    _Atomic uint32_t owner; /**< The number of the turn, 0: none. */
    _Atomic uint32_t count; /**< Turns so far. */
} turn_t;

/**
 * Waits until no other thread has the turn, but no longer than limit_ms for one of them. Returns the number of the own
 * turn, for turn_end; 0 if the thread before has not ended its own.
 */
static inline uint32_t turn_take(turn_t *turn, uint32_t limit_ms) {
    enum { WAITS_PER_MS = 10 };
    uint32_t own = atomic_fetch_add(&turn->count, 1) + 1;
    own = own ? own : atomic_fetch_add(&turn->count, 1) + 1;
    uint32_t before = 0;
    for (uint32_t waits = 0; waits <= limit_ms * WAITS_PER_MS; waits++) {
        uint32_t seen = 0;
        if (atomic_compare_exchange_strong(&turn->owner, &seen, own)) {
            return own;
        }
        waits = seen == before ? waits : 0;
        before = seen;
        await_another_thread();
    }
    return 0;
}

/** As turn_take, but takes the turn away from a thread that the vendor does not return to. */
static inline uint32_t turn_take_away(turn_t *turn, uint32_t limit_ms) {
    for (;;) {
        uint32_t before = atomic_load(&turn->owner);
        uint32_t own = turn_take(turn, limit_ms);
        if (own) {
            return own;
        }
        atomic_compare_exchange_strong(&turn->owner, &before, 0);
    }
}

/** Ends the turn own, unless another thread has taken it away. */
static inline void turn_end(turn_t *turn, uint32_t own) { atomic_compare_exchange_strong(&turn->owner, &own, 0); }
