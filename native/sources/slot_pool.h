/**
 * The slots of every stream and of its encoded images, as slots.c and slot_memory.c share them.
 *
 * The state of a slot is one atomic word. Only the thread that took a slot writes its frame, and a frame is read only
 * under a lease, so no frame needs a lock. pool.latest only says which slot to try first: the bit LATEST of the slot's
 * own word says whether it still is the latest frame, and is checked in the same exchange that adds the lease. A slot
 * that was reused in between can therefore not be mistaken for the latest one.
 */
#pragma once

#include <stdatomic.h>
#include <stdbool.h>

#include "../sdk/lock.h"
#include "../sdk/memory.h"

/** Bits of a slot's state; 0 is a slot that does not exist. */
enum {
    PROVIDED = 1u << 31,  /**< The slot exists. */
    WRITING = 1u << 30,   /**< Taken and not yet published. */
    LATEST = 1u << 29,    /**< The latest frame of its stream. */
    OWN = 1u << 28,       /**< The library owns the memory. */
    RETIRED = 1u << 27,   /**< Ends with its last lease. */
    FREEING = 1u << 26,   /**< One thread unmaps the memory; no other bit is set. */
    LEASES = FREEING - 1, /**< Number of leases. */
};

struct slot {
    _Atomic uint32_t state;
    ml2s_memory memory;
    ml2s_frame frame;
};

struct pool {
    struct slot slots[ML2S_MAX_SLOTS];
    _Atomic uint32_t latest; /**< 1 + index of a slot; 0: none. */
    atomic_flag changing;    /**< Held while slots are provided, taken back, reserved or retired. */
    uint32_t reservations;   /**< Number of slots_reserve without slots_retire. Guarded by changing. */
};

/** Returns the slots of a stream or of its encoded images, or null if there is no such stream. */
struct pool *pool_of(uint32_t stream);

static inline bool slot_exchange(struct slot *slot, uint32_t *seen, uint32_t state) {
    return atomic_compare_exchange_weak(&slot->state, seen, state);
}

/** Returns a slot of pool_of, or null if there is none. */
static inline struct slot *slot_of(uint32_t stream, uint32_t slot) {
    struct pool *pool = slot < ML2S_MAX_SLOTS ? pool_of(stream) : 0;
    return pool ? &pool->slots[slot] : 0;
}

/** Takes a slot for writing if its state is idle. */
static inline bool slot_claim(struct slot *slot, uint32_t idle) {
    return atomic_compare_exchange_strong(&slot->state, &idle, idle | WRITING | 1);
}

/** Replaces the latest slot; latest is 1 + its index, or 0 for none. */
static inline void pool_set_latest(struct pool *pool, uint32_t latest) {
    uint32_t previous = atomic_exchange(&pool->latest, latest);
    if (previous) {
        atomic_fetch_and(&pool->slots[previous - 1].state, ~(uint32_t)LATEST);
    }
}

/** Ends one lease, as ml2s_release. */
ml2s_result slot_release(struct pool *pool, uint32_t index);

/** Ends the slot at index, whose state the caller has set to FREEING. */
void slot_unmap(struct pool *pool, uint32_t index);
