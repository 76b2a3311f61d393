#include <linux/futex.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "../sdk/lock.h"
#include "../sdk/memory.h"

// One that the writer fills and one that the reader has.
enum { SLOTS = ML2S_MOST_INBOX_DEPTH + 2 };

typedef enum { FREE, TAKEN, WAITING, LEASED } use;

typedef struct {
    use use;
    ml2s_memory memory;
    ml2s_message message;
} slot;

/** Zeroed while it was never open. */
typedef struct {
    lock_t lock; /**< Held while slots change hands, never while bytes are copied. */
    uint32_t openings;
    uint32_t depth; /**< 0: closed. */
    uint32_t first; /**< The oldest in queue, a ring. */
    uint32_t count;
    uint64_t left_out;
    _Atomic uint32_t changes; /**< Added messages and closings, for those that wait. */
    _Atomic uint32_t waiting;
    uint32_t queue[ML2S_MOST_INBOX_DEPTH];
    slot slots[SLOTS];
} inbox;

static inbox inboxes[ML2S_MOST_INBOXES];

/** Returns the inbox of a number, locked; null if it was closed, unless a lease of it may be left. */
static inbox *locked(uint32_t number, bool also_closed) {
    inbox *it = &inboxes[number % ML2S_MOST_INBOXES];
    lock(&it->lock);
    if (it->openings == number / ML2S_MOST_INBOXES && (it->depth || also_closed)) {
        return it;
    }
    unlock(&it->lock);
    return NULL;
}

/** Ends the waits for an inbox. */
static void tell(inbox *it) {
    atomic_fetch_add(&it->changes, 1);
    if (atomic_load(&it->waiting)) {
        syscall(SYS_futex, &it->changes, FUTEX_WAKE_PRIVATE, INT32_MAX, NULL, NULL, 0);
    }
}

static ml2s_result unlocked(inbox *it, ml2s_result result) {
    unlock(&it->lock);
    return result;
}

/** Makes a slot free. Without an inbox, nobody uses its memory again. */
static void discard(inbox *it, slot *slot) {
    slot->use = FREE;
    if (!it->depth) {
        memory_unmap(&slot->memory);
    }
}

static uint32_t pop(inbox *it) {
    uint32_t slot = it->queue[it->first];
    it->first = (it->first + 1) % it->depth;
    it->count--;
    return slot;
}

static void drop_until(inbox *it, uint32_t most) {
    while (it->count > most) {
        discard(it, &it->slots[pop(it)]);
        it->left_out++;
    }
}

static bool is_idle(const inbox *it) {
    bool is_leased = it->depth;
    for (uint32_t i = 0; i < SLOTS; i++) {
        is_leased = is_leased || it->slots[i].use != FREE;
    }
    return !is_leased;
}

ml2s_result ml2s_inbox_open(uint32_t depth, uint32_t *number) {
    if (!number || depth < 1 || depth > ML2S_MOST_INBOX_DEPTH) {
        return ML2S_INVALID_ARGUMENT;
    }
    for (uint32_t i = 0; i < ML2S_MOST_INBOXES; i++) {
        inbox *it = &inboxes[i];
        lock(&it->lock);
        if (is_idle(it)) {
            it->depth = depth;
            it->openings = it->openings % (INT32_MAX / ML2S_MOST_INBOXES) + 1;
            it->first = it->count = 0;
            it->left_out = 0;
            *number = it->openings * ML2S_MOST_INBOXES + i;
            return unlocked(it, ML2S_OK);
        }
        unlock(&it->lock);
    }
    return ML2S_BUSY;
}

ml2s_result ml2s_inbox_take(uint32_t number, uint64_t size_bytes, uint32_t *index, ml2s_memory *memory) {
    if (!index || !memory || !size_bytes) {
        return ML2S_INVALID_ARGUMENT;
    }
    inbox *it = locked(number, false);
    if (!it) {
        return ML2S_CLOSED;
    }
    // The one with the smallest memory that is enough, or else any.
    slot *best = NULL;
    for (uint32_t i = 0; i < it->depth + 2; i++) {
        slot *slot = &it->slots[i];
        bool is_enough = slot->memory.size_bytes >= size_bytes;
        bool is_better =
            !best ||
            (is_enough && (best->memory.size_bytes < size_bytes || slot->memory.size_bytes < best->memory.size_bytes));
        if (slot->use == FREE && is_better) {
            best = slot;
        }
    }
    if (!best) {
        return unlocked(it, ML2S_ALL_SLOTS_LEASED);
    }
    best->use = TAKEN;
    unlock(&it->lock);
    if (best->memory.size_bytes < size_bytes) {
        memory_unmap(&best->memory);
        best->memory = memory_map(size_bytes + size_bytes / 2); // The next one may be a little larger.
    }
    *index = (uint32_t)(best - it->slots);
    *memory = best->memory;
    return best->memory.data ? ML2S_OK : ml2s_inbox_release(number, *index) ? ML2S_CLOSED : ML2S_ALL_SLOTS_LEASED;
}

ml2s_result ml2s_inbox_add(uint32_t number, const ml2s_message *message) {
    if (!message || message->struct_size < sizeof *message || message->slot >= SLOTS) {
        return ML2S_INVALID_ARGUMENT;
    }
    inbox *it = locked(number, true);
    if (!it) {
        return ML2S_CLOSED;
    }
    slot *slot = &it->slots[message->slot];
    if (slot->use != TAKEN || message->size_bytes > slot->memory.size_bytes) {
        return unlocked(it, ML2S_INVALID_ARGUMENT);
    }
    if (!it->depth) {
        discard(it, slot);
        return unlocked(it, ML2S_CLOSED);
    }
    drop_until(it, it->depth - 1);
    slot->use = WAITING;
    slot->message = *message;
    slot->message.data = slot->memory.data;
    it->queue[(it->first + it->count++) % it->depth] = message->slot;
    tell(it);
    return unlocked(it, ML2S_OK);
}

ml2s_result ml2s_inbox_wait(uint32_t number) {
    inbox *it = &inboxes[number % ML2S_MOST_INBOXES];
    for (;;) {
        uint32_t seen = atomic_load(&it->changes);
        if (!locked(number, false)) {
            return ML2S_CLOSED;
        }
        bool is_empty = !it->count;
        unlock(&it->lock);
        if (!is_empty) {
            return ML2S_OK;
        }
        atomic_fetch_add(&it->waiting, 1);
        syscall(SYS_futex, &it->changes, FUTEX_WAIT_PRIVATE, seen, NULL, NULL, 0);
        atomic_fetch_sub(&it->waiting, 1);
    }
}

ml2s_result ml2s_inbox_acquire(uint32_t number, ml2s_message *message) {
    if (!message || message->struct_size < sizeof *message) {
        return ML2S_INVALID_ARGUMENT;
    }
    inbox *it = locked(number, false);
    if (!it) {
        return ML2S_CLOSED;
    }
    message->left_out = it->left_out;
    if (!it->count) {
        return unlocked(it, ML2S_TIMEOUT);
    }
    slot *slot = &it->slots[pop(it)];
    slot->use = LEASED;
    *message = slot->message;
    message->left_out = it->left_out;
    return unlocked(it, ML2S_OK);
}

ml2s_result ml2s_inbox_release(uint32_t number, uint32_t index) {
    inbox *it = index < SLOTS ? locked(number, true) : NULL;
    if (!it) {
        return ML2S_INVALID_ARGUMENT;
    }
    slot *slot = &it->slots[index];
    if (slot->use != TAKEN && slot->use != LEASED) {
        return unlocked(it, ML2S_INVALID_ARGUMENT);
    }
    discard(it, slot);
    return unlocked(it, ML2S_OK);
}

ml2s_result ml2s_inbox_skip(uint32_t number) {
    inbox *it = locked(number, false);
    if (!it) {
        return ML2S_CLOSED;
    }
    drop_until(it, 1);
    return unlocked(it, ML2S_OK);
}

ml2s_result ml2s_inbox_close(uint32_t number) {
    inbox *it = locked(number, false);
    if (!it) {
        return ML2S_CLOSED;
    }
    drop_until(it, 0);
    it->depth = 0;
    for (uint32_t i = 0; i < SLOTS; i++) {
        if (it->slots[i].use == FREE) {
            memory_unmap(&it->slots[i].memory);
        }
    }
    tell(it);
    return unlocked(it, ML2S_OK);
}
