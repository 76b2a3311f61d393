#include "slot_pool.h"

static struct pool frames[ML2S_STREAM_COUNT], encoded[ML2S_STREAM_COUNT];

_Static_assert(ML2S_STREAM_COUNT <= ML2S_ENCODED, "the bit ML2S_ENCODED is part of a stream's number");

struct pool *pool_of(uint32_t stream) {
    uint32_t index = stream & ~ML2S_ENCODED;
    if (index >= ML2S_STREAM_COUNT) {
        return 0;
    }
    return stream & ML2S_ENCODED ? &encoded[index] : &frames[index];
}

void slot_unmap(struct pool *pool, uint32_t index) {
    uint32_t self = index + 1;
    atomic_compare_exchange_strong(&pool->latest, &self, 0);
    memory_unmap(&pool->slots[index].memory);
    atomic_store(&pool->slots[index].state, 0);
}

ml2s_result slot_release(struct pool *pool, uint32_t index) {
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
    } while (!slot_exchange(leased, &seen, next));
    if (next == FREEING) {
        slot_unmap(pool, index);
    }
    return ML2S_OK;
}
