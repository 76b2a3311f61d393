#include "dump.h"

#include <android/log.h>

#define LINE_BYTES 32u

void dump_once(bool *is_shown, const char *name, const void *bytes, uint32_t size, uint32_t room) {
    if (*is_shown) {
        return;
    }
    *is_shown = true;
    const uint8_t *from = bytes;
    uint32_t all = size + room;
    for (uint32_t offset = 0; offset < all; offset += LINE_BYTES) {
        char hex[2 * LINE_BYTES + 1];
        uint32_t count = all - offset < LINE_BYTES ? all - offset : LINE_BYTES;
        for (uint32_t i = 0; i < count; i++) {
            hex[2 * i] = "0123456789abcdef"[from[offset + i] >> 4];
            hex[2 * i + 1] = "0123456789abcdef"[from[offset + i] & 15];
        }
        hex[2 * count] = 0;
        __android_log_print(ANDROID_LOG_INFO, "ml2s", "dump %s %u of %u: %s", name, offset, size, hex);
    }
}
