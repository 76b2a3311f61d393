/**
 * Slots: the memory of frames, from the start of a stream to its end. The functions are in the order of a frame's life:
 * ml2s_reserve, ml2s_take, ml2s_publish, ml2s_acquire_latest, ml2s_release, ml2s_retire.
 *
 * The state of a slot is one atomic word. Only the thread that took a slot writes its frame, and a frame is read only
 * under a lease, so no frame needs a lock. pool.latest only says which slot to try first: the bit LATEST of the slot's
 * own word says whether it still is the latest frame, and is checked in the same exchange that adds the lease. A slot
 * that was reused in between can therefore not be mistaken for the latest one.
 */
#include "slots.h"

#include <stdbool.h>

#include "../sdk/lock.h"
#include "../sdk/memory.h"

/** Bits of a slot's state; 0 is a slot that does not exist. */
enum {
    EXISTS = 1u << 31,
    WRITING = 1u << 30,   /**< Taken and not yet published. */
    LATEST = 1u << 29,    /**< The latest frame of its stream. */
    RETIRED = 1u << 28,   /**< Ends with its last lease. */
    FREEING = 1u << 27,   /**< One thread unmaps the memory; no other bit is set. */
    LEASES = FREEING - 1, /**< Number of leases. */
};

struct slot {
    _Atomic uint32_t state;
    ml2s_memory memory; /**< None until a frame needs it. */
    ml2s_frame frame;   /**< As published. */
};

/** The slots of a stream, or of its encoded images. */
static struct pool {
    struct slot slots[ML2S_MAX_SLOTS];
    _Atomic uint32_t latest; /**< 1 + index of a slot; 0: none. */
    lock_t changing;         /**< Held while slots begin or end. */
    uint32_t reservations;   /**< Number of ml2s_reserve without ml2s_retire. Guarded by changing. */
} frames[ML2S_STREAM_COUNT], encoded[ML2S_STREAM_COUNT];

_Static_assert(ML2S_STREAM_COUNT <= ML2S_ENCODED, "the bit ML2S_ENCODED is part of a stream's number");

/** Returns null if there is no such stream. */
static struct pool *pool_of(uint32_t stream) {
    uint32_t index = stream & ~ML2S_ENCODED;
    if (index >= ML2S_STREAM_COUNT) {
        return 0;
    }
    return stream & ML2S_ENCODED ? &encoded[index] : &frames[index];
}

/** Returns null if there is no such slot. */
static struct slot *slot_of(uint32_t stream, uint32_t slot) {
    struct pool *pool = slot < ML2S_MAX_SLOTS ? pool_of(stream) : 0;
    return pool ? &pool->slots[slot] : 0;
}

static bool exchange(struct slot *slot, uint32_t *seen, uint32_t state) {
    return atomic_compare_exchange_weak(&slot->state, seen, state);
}

/** Makes a slot exist, without memory. One that still ends with its last lease goes on instead. */
static void reserve_slot(struct slot *slot) {
    uint32_t seen = atomic_load(&slot->state);
    do {
        while (seen & FREEING) {
            await_another_thread();
            seen = atomic_load(&slot->state);
        }
    } while (!exchange(slot, &seen, (seen | EXISTS) & ~(uint32_t)RETIRED));
}

ml2s_result ml2s_reserve(uint32_t stream) {
    struct pool *pool = pool_of(stream);
    if (!pool) {
        return ML2S_INVALID_ARGUMENT;
    }
    lock(&pool->changing);
    for (uint32_t i = 0; i < ML2S_MAX_SLOTS && !pool->reservations; i++) {
        reserve_slot(&pool->slots[i]);
    }
    pool->reservations++;
    unlock(&pool->changing);
    return ML2S_OK;
}

/** Takes a slot for writing if it is idle: not leased, and not the latest. */
static bool claim(struct slot *slot) {
    uint32_t idle = EXISTS;
    return atomic_compare_exchange_strong(&slot->state, &idle, EXISTS | WRITING | 1);
}

/** Ends the slot at index, whose state the caller has set to FREEING. */
static void unmap(struct pool *pool, uint32_t index) {
    uint32_t self = index + 1;
    atomic_compare_exchange_strong(&pool->latest, &self, 0);
    memory_unmap(&pool->slots[index].memory);
    atomic_store(&pool->slots[index].state, 0);
}

/** Ends one lease, and with the last one a retired slot. */
static ml2s_result release(struct pool *pool, uint32_t index) {
    struct slot *leased = &pool->slots[index];
    uint32_t seen = atomic_load(&leased->state);
    uint32_t next;
    do {
        if (!(seen & LEASES)) {
            return ML2S_INVALID_ARGUMENT;
        }
        next = seen - 1;
        if (!(next & LEASES)) {
            next = next & RETIRED ? FREEING : next & ~(uint32_t)WRITING;
        }
    } while (!exchange(leased, &seen, next));
    if (next == FREEING) {
        unmap(pool, index);
    }
    return ML2S_OK;
}

/** Unmaps the memory of idle slots of another size, which the stream no longer uses. */
static void unmap_other_sizes(struct pool *pool, uint64_t size_bytes) {
    for (uint32_t i = 0; i < ML2S_MAX_SLOTS; i++) {
        struct slot *slot = &pool->slots[i];
        if (claim(slot)) {
            if (slot->memory.size_bytes != size_bytes) {
                memory_unmap(&slot->memory);
            }
            release(pool, i);
        }
    }
}

/** Gives a claimed slot memory of size_bytes. Returns false if the system has none. */
static bool resize(struct pool *pool, struct slot *slot, uint64_t size_bytes) {
    if (slot->memory.size_bytes != size_bytes) {
        memory_unmap(&slot->memory);
        unmap_other_sizes(pool, size_bytes);
        slot->memory = memory_map(size_bytes);
    }
    return slot->memory.data;
}

ml2s_result ml2s_take(uint32_t stream, uint64_t size_bytes, uint32_t *slot, ml2s_memory *memory) {
    struct pool *pool = pool_of(stream);
    if (!pool || !size_bytes || !slot || !memory) {
        return ML2S_INVALID_ARGUMENT;
    }
    uint32_t index = 0;
    while (index < ML2S_MAX_SLOTS && !claim(&pool->slots[index])) {
        index++;
    }
    if (index == ML2S_MAX_SLOTS) {
        return ML2S_ALL_SLOTS_LEASED;
    }
    if (!resize(pool, &pool->slots[index], size_bytes)) {
        release(pool, index);
        return ML2S_ALL_SLOTS_LEASED;
    }
    *slot = index;
    *memory = pool->slots[index].memory;
    return ML2S_OK;
}

ml2s_memory slots_memory(uint32_t stream, uint32_t slot) {
    struct slot *leased = slot_of(stream, slot);
    return leased ? leased->memory : (ml2s_memory){0, 0};
}

/** Replaces the latest slot; latest is 1 + its index, or 0 for none. */
static void set_latest(struct pool *pool, uint32_t latest) {
    uint32_t previous = atomic_exchange(&pool->latest, latest);
    if (previous) {
        atomic_fetch_and(&pool->slots[previous - 1].state, ~(uint32_t)LATEST);
    }
}

ml2s_result ml2s_publish(const ml2s_frame *frame) {
    bool is_whole = frame && frame->struct_size >= sizeof *frame;
    struct slot *slot = is_whole ? slot_of(frame->stream, frame->slot) : 0;
    uint32_t seen = slot ? atomic_load(&slot->state) : 0;
    if (!(seen & WRITING)) {
        return ML2S_INVALID_ARGUMENT;
    }
    slot->frame = *frame;
    slot->frame.data = slot->memory.data;
    while (!exchange(slot, &seen, (seen & ~(uint32_t)WRITING) | LATEST)) {
    }
    set_latest(pool_of(frame->stream), frame->slot + 1);
    return ML2S_OK;
}

ml2s_result ml2s_unpublish(uint32_t stream) {
    struct pool *pool = pool_of(stream);
    if (!pool) {
        return ML2S_INVALID_ARGUMENT;
    }
    lock(&pool->changing); // In between, the slot must not end and begin anew.
    set_latest(pool, 0);
    unlock(&pool->changing);
    return ML2S_OK;
}

/** Leases the latest slot; null when there is none. */
static struct slot *lease_latest(struct pool *pool, uint32_t *index) {
    uint32_t latest;
    while ((latest = atomic_load(&pool->latest))) {
        struct slot *slot = &pool->slots[latest - 1];
        uint32_t seen = atomic_load(&slot->state);
        while (seen & LATEST) {
            if (exchange(slot, &seen, seen + 1)) {
                *index = latest - 1;
                return slot;
            }
        }
    }
    return 0;
}

ml2s_result ml2s_acquire_latest(uint32_t stream, int64_t after_nanos, ml2s_frame *frame) {
    struct pool *pool = pool_of(stream);
    if (!pool || !frame || frame->struct_size < sizeof *frame) {
        return ML2S_INVALID_ARGUMENT;
    }
    uint32_t index;
    struct slot *slot = lease_latest(pool, &index);
    if (!slot) {
        return ML2S_TIMEOUT;
    }
    if (slot->frame.capture_nanos <= after_nanos) {
        release(pool, index);
        return ML2S_TIMEOUT;
    }
    uint32_t struct_size = frame->struct_size;
    *frame = slot->frame;
    frame->struct_size = struct_size;
    return ML2S_OK;
}

ml2s_result ml2s_release(uint32_t stream, uint32_t slot) {
    return slot_of(stream, slot) ? release(pool_of(stream), slot) : ML2S_INVALID_ARGUMENT;
}

/** Ends the slot at index at once, or with its last lease. */
static void retire_slot(struct pool *pool, uint32_t index) {
    struct slot *slot = &pool->slots[index];
    uint32_t seen = atomic_load(&slot->state);
    while (seen & EXISTS) {
        bool is_idle = !(seen & LEASES);
        if (exchange(slot, &seen, is_idle ? FREEING : seen | RETIRED)) {
            if (is_idle) {
                unmap(pool, index);
            }
            return;
        }
    }
}

ml2s_result ml2s_retire(uint32_t stream) {
    struct pool *pool = pool_of(stream);
    if (!pool) {
        return ML2S_INVALID_ARGUMENT;
    }
    lock(&pool->changing);
    bool was_reserved = pool->reservations;
    if (was_reserved && !--pool->reservations) {
        set_latest(pool, 0);
        for (uint32_t i = 0; i < ML2S_MAX_SLOTS; i++) {
            retire_slot(pool, i);
        }
    }
    unlock(&pool->changing);
    return was_reserved ? ML2S_OK : ML2S_INVALID_ARGUMENT;
}
