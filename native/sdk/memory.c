#include "memory.h"

#include <stdatomic.h>
#include <sys/mman.h>

static _Atomic uint64_t mapped_bytes;

ml2s_memory memory_map(uint64_t size_bytes) {
    void *data = mmap(0, size_bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (data == MAP_FAILED) {
        return (ml2s_memory){0, 0};
    }
    atomic_fetch_add(&mapped_bytes, size_bytes);
    return (ml2s_memory){data, size_bytes};
}

void memory_unmap(ml2s_memory *memory) {
    if (memory->data) {
        munmap(memory->data, memory->size_bytes);
        atomic_fetch_sub(&mapped_bytes, memory->size_bytes);
    }
    *memory = (ml2s_memory){0, 0};
}

uint64_t memory_mapped_bytes(void) { return atomic_load(&mapped_bytes); }
