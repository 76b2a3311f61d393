// Preloaded into a headset: how much memory libml2sensors.so has mapped for frames, at most at a time. Writes it to the
// file named by ML2S_MAPPED when the process ends. Only that library finds this mmap: it alone asks for one without a
// version of glibc's, and mapped.map gives this one a version of its own.
#define _GNU_SOURCE
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/syscall.h>
#include <unistd.h>

static atomic_llong mapped_bytes, peak_bytes;

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

int munmap(void *address, size_t size_bytes) {
    add(-(long long)size_bytes);
    return (int)syscall(SYS_munmap, address, size_bytes);
}

__attribute__((destructor)) static void report(void) {
    const char *path = getenv("ML2S_MAPPED");
    FILE *file = path && atomic_load(&peak_bytes) ? fopen(path, "w") : NULL;
    if (!file) {
        return;
    }
    fprintf(file, "%lld %lld\n", atomic_load(&peak_bytes), atomic_load(&mapped_bytes));
    fclose(file);
}
