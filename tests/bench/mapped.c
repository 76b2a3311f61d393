// Preloaded into a headset: how much memory libml2sensors.so has mapped for frames, at most at a time and at the end,
// and how much of what it unmapped was used. Writes these bytes to the file named by ML2S_MAPPED when the process ends.
// Only that library finds this mmap: it alone asks for one without a version of glibc's, and mapped.map gives this one
// a version of its own.
#define _GNU_SOURCE
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <unistd.h>

enum { PAGE_BYTES = 4096 };

static atomic_llong mapped_bytes, peak_bytes, used_bytes;

static void add(long long size_bytes) {
    long long now = atomic_fetch_add(&mapped_bytes, size_bytes) + size_bytes;
    long long peak = atomic_load(&peak_bytes);
    while (peak < now && !atomic_compare_exchange_weak(&peak_bytes, &peak, now)) {
    }
}

void *mmap(void *address, size_t size_bytes, int protection, int flags, int file, long offset) {
    long mapped = syscall(SYS_mmap, address, size_bytes, protection, flags, file, offset);
    if (mapped != -1) {
        add((long long)size_bytes);
    }
    return (void *)mapped;
}

static long long used_bytes_of(char *address, size_t size_bytes) {
    long long used = 0;
    for (size_t offset = 0; offset < size_bytes; offset += PAGE_BYTES) {
        unsigned char is_resident = 0;
        mincore(address + offset, 1, &is_resident);
        used += is_resident & 1 ? PAGE_BYTES : 0;
    }
    return used;
}

int munmap(void *address, size_t size_bytes) {
    add(-(long long)size_bytes);
    atomic_fetch_add(&used_bytes, used_bytes_of(address, size_bytes));
    return (int)syscall(SYS_munmap, address, size_bytes);
}

__attribute__((destructor)) static void report(void) {
    const char *path = getenv("ML2S_MAPPED");
    FILE *file = path && atomic_load(&peak_bytes) ? fopen(path, "w") : NULL;
    if (!file) {
        return;
    }
    fprintf(file, "%lld %lld %lld\n", atomic_load(&peak_bytes), atomic_load(&mapped_bytes), atomic_load(&used_bytes));
    fclose(file);
}
