/**
 * Slots whose memory is the library's own, beside those of ml2s_provide: mapped when a frame first needs it, in the
 * size of that frame, and unmapped as soon as nobody reads it and nobody wants the stream any more. Any thread.
 */
#pragma once

#include "../sdk/ml2s.h"

/** Gives a stream ML2S_MAX_SLOTS slots, once for each slots_retire. ML2S_BUSY while it has slots of ml2s_provide. */
ml2s_result slots_reserve(uint32_t stream);

/** Ends one slots_reserve. After the last one no frame is the latest, and each slot goes with its last lease. */
ml2s_result slots_retire(uint32_t stream);

/** The memory of a slot that the caller has a lease of; else it may be any slot's or none. */
ml2s_memory slots_memory(uint32_t stream, uint32_t slot);

/**
 * As ml2s_take, for a frame of size_bytes: a slot of slots_reserve has that much memory, rounded up to 64, and no more;
 * one of ml2s_provide has what was provided.
 */
ml2s_result slots_take(uint32_t stream, uint64_t size_bytes, uint32_t *slot, ml2s_memory *memory);
