/**
 * Slots with memory of the library, in addition to those of ml2s_provide. The memory of a slot is mapped when a frame
 * first needs it, in the size of the frame. It is unmapped when the stream has ended and the last lease is released.
 * All functions are thread-safe, and take `stream | ML2S_ENCODED`, too.
 */
#pragma once

#include "../sdk/ml2s.h"

/**
 * Gives a stream ML2S_MAX_SLOTS slots; each call is ended by one slots_retire. Returns ML2S_BUSY while the stream has
 * slots of ml2s_provide.
 */
ml2s_result slots_reserve(uint32_t stream);

/** Ends one slots_reserve. The last one withdraws the latest frame; each slot ends with its last lease. */
ml2s_result slots_retire(uint32_t stream);

/** Returns the memory of a slot. The caller must have a lease of the slot. */
ml2s_memory slots_memory(uint32_t stream, uint32_t slot);

/**
 * Takes a slot as ml2s_take does, for a frame of size_bytes. The memory of a slot of slots_reserve has that size,
 * rounded up to 64; a slot of ml2s_provide has the size that was provided.
 */
ml2s_result slots_take(uint32_t stream, uint64_t size_bytes, uint32_t *slot, ml2s_memory *memory);
