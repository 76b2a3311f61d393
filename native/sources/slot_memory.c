#include "slot_memory.h"

#include "slot_pool.h"

enum { ALIGNMENT = 64 };

/** Unmaps the memory of idle slots of another size, which the stream no longer uses. */
static void unmap_other_sizes(struct pool *pool, uint64_t size_bytes) {
    for (uint32_t i = 0; i < ML2S_MAX_SLOTS; i++) {
        struct slot *slot = &pool->slots[i];
        if (slot_claim(slot, PROVIDED | OWN)) {
            if (slot->memory.size_bytes != size_bytes) {
                memory_unmap(&slot->memory);
            }
            slot_release(pool, i);
        }
    }
}

/** Gives a slot that the caller has claimed memory of size_bytes. Returns false if the system has none. */
static bool resize(struct pool *pool, struct slot *slot, uint64_t size_bytes) {
    size_bytes = (size_bytes + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
    if (slot->memory.size_bytes != size_bytes) {
        memory_unmap(&slot->memory);
        unmap_other_sizes(pool, size_bytes);
        slot->memory = memory_map(size_bytes);
    }
    return slot->memory.data;
}

ml2s_result slots_take(uint32_t stream, uint64_t size_bytes, uint32_t *slot, ml2s_memory *memory) {
    struct pool *pool = pool_of(stream);
    if (!pool || !size_bytes || !slot || !memory) {
        return ML2S_INVALID_ARGUMENT;
    }
    for (uint32_t i = 0; i < ML2S_MAX_SLOTS; i++) {
        struct slot *candidate = &pool->slots[i];
        bool is_own = slot_claim(candidate, PROVIDED | OWN);
        if (!is_own && !slot_claim(candidate, PROVIDED)) {
            continue;
        }
        if (is_own && !resize(pool, candidate, size_bytes)) {
            slot_release(pool, i);
            break;
        }
        *slot = i;
        *memory = candidate->memory;
        return ML2S_OK;
    }
    return ML2S_ALL_SLOTS_LEASED;
}

ml2s_memory slots_memory(uint32_t stream, uint32_t slot) {
    struct slot *leased = slot_of(stream, slot);
    return leased ? leased->memory : (ml2s_memory){0, 0};
}

/** Ends the slot at index at once, or with its last lease. */
static void retire_slot(struct pool *pool, uint32_t index) {
    struct slot *slot = &pool->slots[index];
    uint32_t seen = atomic_load(&slot->state);
    while (seen & OWN) {
        bool is_idle = !(seen & LEASES);
        if (slot_exchange(slot, &seen, is_idle ? FREEING : seen | RETIRED)) {
            if (is_idle) {
                slot_unmap(pool, index);
            }
            return;
        }
    }
}

/** Makes a slot own memory again, or for the first time. Returns false if its memory is the caller's. */
static bool reserve_slot(struct slot *slot) {
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
            slot->memory = (ml2s_memory){0, 0}; // The caller still owns memory that it provided before.
        }
    } while (!slot_exchange(slot, &seen, seen ? seen & ~(uint32_t)RETIRED : PROVIDED | OWN));
    return true;
}

ml2s_result slots_reserve(uint32_t stream) {
    struct pool *pool = pool_of(stream);
    if (!pool) {
        return ML2S_INVALID_ARGUMENT;
    }
    bool are_own = true;
    lock(&pool->changing);
    for (uint32_t i = 0; i < ML2S_MAX_SLOTS && !pool->reservations && are_own; i++) {
        are_own = reserve_slot(&pool->slots[i]);
    }
    pool->reservations += are_own;
    unlock(&pool->changing);
    return are_own ? ML2S_OK : ML2S_BUSY;
}

ml2s_result slots_retire(uint32_t stream) {
    struct pool *pool = pool_of(stream);
    if (!pool) {
        return ML2S_INVALID_ARGUMENT;
    }
    lock(&pool->changing);
    bool was_reserved = pool->reservations;
    if (was_reserved && !--pool->reservations) {
        pool_set_latest(pool, 0);
        for (uint32_t i = 0; i < ML2S_MAX_SLOTS; i++) {
            retire_slot(pool, i);
        }
    }
    unlock(&pool->changing);
    return was_reserved ? ML2S_OK : ML2S_INVALID_ARGUMENT;
}
