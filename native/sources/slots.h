/** Functions on slots that only the library calls; ml2s.h has the public ones. */
#pragma once

#include "../sdk/ml2s.h"

/** Returns the memory of a slot, or none. The caller must have a lease of the slot. Takes `stream | ML2S_ENCODED`, too.
 */
ml2s_memory slots_memory(uint32_t stream, uint32_t slot);
