// The slots of every stream. A slot's state is one atomic word; its frame is written only by the one that took it, and
// read only under a lease, so neither needs a lock. `latest` is a hint at where to look: whether the slot still is the
// latest is said by its own word, in the very exchange that counts the lease, so a slot that was used again in between
// cannot be mistaken for it.
#include "slots.h"

#include <stdatomic.h>
#include <stdbool.h>

#include "../sdk/lock.h"
#include "../sdk/memory.h"

enum {
    PROVIDED = 1u << 31,  /**< Exists. */
    WRITING = 1u << 30,   /**< Taken, not yet published. */
    LATEST = 1u << 29,    /**< Kept for readers to come. */
    OWN = 1u << 28,       /**< Its memory is the library's. */
    RETIRED = 1u << 27,   /**< Goes with its last lease. */
    FREEING = 1u << 26,   /**< Alone: its memory is being unmapped. */
    LEASES = FREEING - 1, /**< How many hold it. */
    ALIGNMENT = 64,
};

struct slot {
    _Atomic uint32_t state;
    ml2s_memory memory;
    ml2s_frame frame;
};

static struct pool {
    struct slot slots[ML2S_MAX_SLOTS];
    _Atomic uint32_t latest; /**< 1 + slot; 0 for none. */
    atomic_flag providing;
    uint32_t reservations; /**< Of slots_reserve; under providing. */
} pools[ML2S_STREAM_COUNT];

static bool exchange(struct slot *slot, uint32_t *seen, uint32_t state) {
    return atomic_compare_exchange_weak(&slot->state, seen, state);
}

static bool is_slot(uint32_t stream, uint32_t slot) { return stream < ML2S_STREAM_COUNT && slot < ML2S_MAX_SLOTS; }

static bool withdraw(struct slot *slot, uint32_t idle) {
    return atomic_compare_exchange_strong(&slot->state, &idle, 0);
}

/** Takes every slot out of use, or none. */
static ml2s_result withdraw_all(struct pool *pool) {
    uint32_t latest = atomic_load(&pool->latest);
    uint32_t withdrawn = 0;
    ml2s_result result = ML2S_OK;
    for (uint32_t i = 0; i < ML2S_MAX_SLOTS && !result; i++) {
        if (i + 1 == latest || !atomic_load(&pool->slots[i].state)) {
            continue;
        } else if (withdraw(&pool->slots[i], PROVIDED)) {
            withdrawn |= 1u << i;
        } else {
            result = ML2S_BUSY;
        }
    }
    // With the others withdrawn nobody can publish any more, so `latest` stands still.
    if (!result && latest) {
        atomic_store(&pool->latest, 0);
        if (!withdraw(&pool->slots[latest - 1], PROVIDED | LATEST)) {
            atomic_store(&pool->latest, latest);
            result = ML2S_BUSY;
        }
    }
    for (uint32_t i = 0; i < ML2S_MAX_SLOTS && result; i++) {
        if (withdrawn & (1u << i)) {
            atomic_store(&pool->slots[i].state, PROVIDED);
        }
    }
    return result;
}

ml2s_result ml2s_provide(uint32_t stream, const ml2s_memory *slots, uint32_t count) {
    if (stream >= ML2S_STREAM_COUNT || count > ML2S_MAX_SLOTS || (count && !slots)) {
        return ML2S_INVALID_ARGUMENT;
    }
    for (uint32_t i = 0; i < count; i++) {
        if (!slots[i].data || !slots[i].size_bytes || (uintptr_t)slots[i].data % 64) {
            return ML2S_INVALID_ARGUMENT;
        }
    }
    struct pool *pool = &pools[stream];
    if (atomic_flag_test_and_set(&pool->providing)) {
        return ML2S_BUSY;
    }
    ml2s_result result = withdraw_all(pool);
    for (uint32_t i = 0; i < count && !result; i++) {
        pool->slots[i].memory = slots[i];
        atomic_store(&pool->slots[i].state, PROVIDED);
    }
    atomic_flag_clear(&pool->providing);
    return result;
}

static bool claim(struct slot *slot, uint32_t idle) {
    return atomic_compare_exchange_strong(&slot->state, &idle, idle | WRITING | 1);
}

/** Unmaps what the idle slots of another size have: the mode that they were for is over. */
static void trim(struct pool *pool, uint64_t size_bytes) {
    for (uint32_t i = 0; i < ML2S_MAX_SLOTS; i++) {
        struct slot *slot = &pool->slots[i];
        if (claim(slot, PROVIDED | OWN)) {
            if (slot->memory.size_bytes != size_bytes) {
                memory_unmap(&slot->memory);
            }
            ml2s_release((uint32_t)(pool - pools), i);
        }
    }
}

/** For the one that has claimed slot. */
static bool resize(struct pool *pool, struct slot *slot, uint64_t size_bytes) {
    size_bytes = (size_bytes + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
    if (slot->memory.size_bytes != size_bytes) {
        memory_unmap(&slot->memory);
        trim(pool, size_bytes);
        slot->memory = memory_map(size_bytes);
    }
    return slot->memory.data;
}

ml2s_result slots_take(uint32_t stream, uint64_t size_bytes, uint32_t *slot, ml2s_memory *memory) {
    if (stream >= ML2S_STREAM_COUNT || !size_bytes || !slot || !memory) {
        return ML2S_INVALID_ARGUMENT;
    }
    struct pool *pool = &pools[stream];
    for (uint32_t i = 0; i < ML2S_MAX_SLOTS; i++) {
        struct slot *candidate = &pool->slots[i];
        bool is_own = claim(candidate, PROVIDED | OWN);
        if (!is_own && !claim(candidate, PROVIDED)) {
            continue;
        }
        if (is_own && !resize(pool, candidate, size_bytes)) {
            ml2s_release(stream, i);
            break;
        }
        *slot = i;
        *memory = candidate->memory;
        return ML2S_OK;
    }
    return ML2S_ALL_SLOTS_LEASED;
}

ml2s_memory slots_memory(uint32_t stream, uint32_t slot) {
    return is_slot(stream, slot) ? pools[stream].slots[slot].memory : (ml2s_memory){0, 0};
}

ml2s_result ml2s_take(uint32_t stream, uint32_t *slot, ml2s_memory *memory) {
    if (stream >= ML2S_STREAM_COUNT || !slot || !memory) {
        return ML2S_INVALID_ARGUMENT;
    }
    for (uint32_t i = 0; i < ML2S_MAX_SLOTS; i++) {
        struct slot *candidate = &pools[stream].slots[i];
        if (claim(candidate, PROVIDED)) {
            *slot = i;
            *memory = candidate->memory;
            return ML2S_OK;
        }
    }
    return ML2S_ALL_SLOTS_LEASED;
}

/** Makes latest, 1 + slot or 0, the latest, instead of the one that was. */
static void succeed(struct pool *pool, uint32_t latest) {
    uint32_t previous = atomic_exchange(&pool->latest, latest);
    if (previous) {
        atomic_fetch_and(&pool->slots[previous - 1].state, ~(uint32_t)LATEST);
    }
}

ml2s_result ml2s_publish(const ml2s_frame *frame) {
    if (!frame || frame->struct_size < sizeof *frame || !is_slot(frame->stream, frame->slot)) {
        return ML2S_INVALID_ARGUMENT;
    }
    struct pool *pool = &pools[frame->stream];
    struct slot *slot = &pool->slots[frame->slot];
    uint32_t seen = atomic_load(&slot->state);
    if (!(seen & WRITING)) {
        return ML2S_INVALID_ARGUMENT;
    }
    slot->frame = *frame;
    slot->frame.data = slot->memory.data;
    while (!exchange(slot, &seen, (seen & ~WRITING) | LATEST)) {
    }
    succeed(pool, frame->slot + 1);
    return ML2S_OK;
}

ml2s_result ml2s_unpublish(uint32_t stream) {
    if (stream >= ML2S_STREAM_COUNT) {
        return ML2S_INVALID_ARGUMENT;
    }
    // Who takes slots back relies on what is the latest
    struct pool *pool = &pools[stream];
    lock(&pool->providing);
    succeed(pool, 0);
    unlock(&pool->providing);
    return ML2S_OK;
}

/** Ends the slot that is number index, whose state has become FREEING. */
static void unmap_slot(struct pool *pool, uint32_t index) {
    uint32_t self = index + 1;
    atomic_compare_exchange_strong(&pool->latest, &self, 0);
    memory_unmap(&pool->slots[index].memory);
    atomic_store(&pool->slots[index].state, 0);
}

/** Ends the slot that is number index as soon as nobody has it. */
static void retire(struct pool *pool, uint32_t index) {
    struct slot *slot = &pool->slots[index];
    uint32_t seen = atomic_load(&slot->state);
    while (seen & OWN) {
        bool is_idle = !(seen & LEASES);
        if (exchange(slot, &seen, is_idle ? FREEING : seen | RETIRED)) {
            if (is_idle) {
                unmap_slot(pool, index);
            }
            return;
        }
    }
}

/** Makes a slot of the library's own of one that has none, or that is to end. Returns false if it is the caller's. */
static bool revive(struct slot *slot) {
    uint32_t seen = atomic_load(&slot->state);
    do {
        while (seen & FREEING) {
            await_another_thread();
            seen = atomic_load(&slot->state);
        }
        if (seen && !(seen & OWN)) {
            return false;
        }
        if (!seen) {
            slot->memory = (ml2s_memory){0, 0}; // What a caller provided before is still the caller's.
        }
    } while (!exchange(slot, &seen, seen ? seen & ~(uint32_t)RETIRED : PROVIDED | OWN));
    return true;
}

ml2s_result slots_reserve(uint32_t stream) {
    if (stream >= ML2S_STREAM_COUNT) {
        return ML2S_INVALID_ARGUMENT;
    }
    struct pool *pool = &pools[stream];
    bool are_own = true;
    lock(&pool->providing);
    for (uint32_t i = 0; i < ML2S_MAX_SLOTS && !pool->reservations && are_own; i++) {
        are_own = revive(&pool->slots[i]);
    }
    pool->reservations += are_own;
    unlock(&pool->providing);
    return are_own ? ML2S_OK : ML2S_BUSY;
}

ml2s_result slots_retire(uint32_t stream) {
    if (stream >= ML2S_STREAM_COUNT) {
        return ML2S_INVALID_ARGUMENT;
    }
    struct pool *pool = &pools[stream];
    lock(&pool->providing);
    bool was_reserved = pool->reservations;
    if (was_reserved && !--pool->reservations) {
        succeed(pool, 0);
        for (uint32_t i = 0; i < ML2S_MAX_SLOTS; i++) {
            retire(pool, i);
        }
    }
    unlock(&pool->providing);
    return was_reserved ? ML2S_OK : ML2S_INVALID_ARGUMENT;
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
    if (stream >= ML2S_STREAM_COUNT || !frame || frame->struct_size < sizeof *frame) {
        return ML2S_INVALID_ARGUMENT;
    }
    uint32_t index;
    struct slot *slot = lease_latest(&pools[stream], &index);
    if (!slot) {
        return ML2S_TIMEOUT;
    }
    if (slot->frame.capture_nanos <= after_nanos) {
        ml2s_release(stream, index);
        return ML2S_TIMEOUT;
    }
    uint32_t struct_size = frame->struct_size;
    *frame = slot->frame;
    frame->struct_size = struct_size;
    return ML2S_OK;
}

ml2s_result ml2s_release(uint32_t stream, uint32_t slot) {
    if (!is_slot(stream, slot)) {
        return ML2S_INVALID_ARGUMENT;
    }
    struct slot *leased = &pools[stream].slots[slot];
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
        unmap_slot(&pools[stream], slot);
    }
    return ML2S_OK;
}
