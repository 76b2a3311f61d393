// Slots: provided memory, writing, the latest frame, and leases.
#include "slot_pool.h"

static bool take_back(struct slot *slot, uint32_t idle) {
    return atomic_compare_exchange_strong(&slot->state, &idle, 0);
}

/** Takes back every slot, or none. */
static ml2s_result take_back_all(struct pool *pool) {
    uint32_t latest = atomic_load(&pool->latest);
    uint32_t taken_back = 0;
    ml2s_result result = ML2S_OK;
    for (uint32_t i = 0; i < ML2S_MAX_SLOTS && !result; i++) {
        if (i + 1 == latest || !atomic_load(&pool->slots[i].state)) {
            continue;
        } else if (take_back(&pool->slots[i], PROVIDED)) {
            taken_back |= 1u << i;
        } else {
            result = ML2S_BUSY;
        }
    }
    // With the others taken back no thread can publish, so `latest` does not change.
    if (!result && latest) {
        atomic_store(&pool->latest, 0);
        if (!take_back(&pool->slots[latest - 1], PROVIDED | LATEST)) {
            atomic_store(&pool->latest, latest);
            result = ML2S_BUSY;
        }
    }
    for (uint32_t i = 0; i < ML2S_MAX_SLOTS && result; i++) {
        if (taken_back & (1u << i)) {
            atomic_store(&pool->slots[i].state, PROVIDED);
        }
    }
    return result;
}

ml2s_result ml2s_provide(uint32_t stream, const ml2s_memory *slots, uint32_t count) {
    struct pool *pool = pool_of(stream);
    if (!pool || count > ML2S_MAX_SLOTS || (count && !slots)) {
        return ML2S_INVALID_ARGUMENT;
    }
    for (uint32_t i = 0; i < count; i++) {
        if (!slots[i].data || !slots[i].size_bytes || (uintptr_t)slots[i].data % 64) {
            return ML2S_INVALID_ARGUMENT;
        }
    }
    if (atomic_flag_test_and_set(&pool->changing)) {
        return ML2S_BUSY;
    }
    ml2s_result result = take_back_all(pool);
    for (uint32_t i = 0; i < count && !result; i++) {
        pool->slots[i].memory = slots[i];
        atomic_store(&pool->slots[i].state, PROVIDED);
    }
    atomic_flag_clear(&pool->changing);
    return result;
}

ml2s_result ml2s_take(uint32_t stream, uint32_t *slot, ml2s_memory *memory) {
    struct pool *pool = pool_of(stream);
    if (!pool || !slot || !memory) {
        return ML2S_INVALID_ARGUMENT;
    }
    for (uint32_t i = 0; i < ML2S_MAX_SLOTS; i++) {
        struct slot *candidate = &pool->slots[i];
        if (slot_claim(candidate, PROVIDED)) {
            *slot = i;
            *memory = candidate->memory;
            return ML2S_OK;
        }
    }
    return ML2S_ALL_SLOTS_LEASED;
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
    while (!slot_exchange(slot, &seen, (seen & ~WRITING) | LATEST)) {
    }
    pool_set_latest(pool_of(frame->stream), frame->slot + 1);
    return ML2S_OK;
}

ml2s_result ml2s_unpublish(uint32_t stream) {
    struct pool *pool = pool_of(stream);
    if (!pool) {
        return ML2S_INVALID_ARGUMENT;
    }
    // take_back_all relies on an unchanged latest slot
    lock(&pool->changing);
    pool_set_latest(pool, 0);
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
            if (slot_exchange(slot, &seen, seen + 1)) {
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
        slot_release(pool, index);
        return ML2S_TIMEOUT;
    }
    uint32_t struct_size = frame->struct_size;
    *frame = slot->frame;
    frame->struct_size = struct_size;
    return ML2S_OK;
}

ml2s_result ml2s_release(uint32_t stream, uint32_t slot) {
    return slot_of(stream, slot) ? slot_release(pool_of(stream), slot) : ML2S_INVALID_ARGUMENT;
}
