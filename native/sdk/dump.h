/**
 * Shows in the device's log, once, what the vendor has written into a struct, and behind it.
 *
 * Layouts that only one public text has may be shorter than those of a headset. Room behind such a struct takes what is
 * written too much, and tells it by its pattern.
 */
#pragma once

#include <stdatomic.h>
#include <stdint.h>
#include <string.h>

#define DUMP_ROOM_BYTES 64
#define DUMP_PATTERN 0xa5

#define WITH_ROOM(type)                                                                                                \
    struct {                                                                                                           \
        __typeof__(type) of;                                                                                           \
        uint8_t room[DUMP_ROOM_BYTES];                                                                                 \
    }

/** Fills the room behind a struct before a function of the vendor. */
static inline void dump_begin(uint8_t room[DUMP_ROOM_BYTES]) { memset(room, DUMP_PATTERN, DUMP_ROOM_BYTES); }

/**
 * Logs a struct and the room behind it, unless is_shown: a line for 32 bytes each, "dump NAME OFFSET of SIZE: HEX".
 * SIZE is that of the struct alone.
 */
void dump_once(atomic_flag *is_shown, const char *name, const void *bytes, uint32_t size);
