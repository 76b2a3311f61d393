/** Memory that the library maps in whole pages, outside the Java heap. */
#pragma once

#include "ml2s.h"

/** Maps size_bytes of zeroed memory. Returns null data if that fails. Thread-safe. */
ml2s_memory memory_map(uint64_t size_bytes);

/** Unmaps memory of memory_map and clears the structure. Does nothing if data is null. Thread-safe. */
void memory_unmap(ml2s_memory *memory);

/** Returns the number of bytes that are mapped. Thread-safe. */
uint64_t memory_mapped_bytes(void);
