/** Memory of the library's own, in whole pages, outside of Java's heap. */
#pragma once

#include "ml2s.h"

/** Maps size_bytes of zeroed memory. Returns no data when the system has none. Any thread. */
ml2s_memory memory_map(uint64_t size_bytes);

/** Unmaps memory, which memory_map gave; empties it. Does nothing if it is empty. Any thread. */
void memory_unmap(ml2s_memory *memory);

/** What is mapped now. Any thread. */
uint64_t memory_mapped_bytes(void);
