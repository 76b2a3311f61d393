/**
 * Shows in the device's log, once, what the vendor has written into a struct, and behind it.
 *
 * Layouts of public texts may be shorter than those of a headset. Room behind a struct takes what is written too much,
 * and tells it by its pattern.
 */
#pragma once

#include <stdbool.h>
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
 * Logs a struct and the room behind it, which may be 0, and sets is_shown, unless it is set: a line for 32 bytes each,
 * "dump NAME OFFSET of SIZE: HEX". SIZE is that of the struct alone.
 */
void dump_once(bool *is_shown, const char *name, const void *bytes, uint32_t size, uint32_t room);

/** Logs a struct of WITH_ROOM, once for each place in the code. */
#define DUMP_ONCE(name, with_room)                                                                                     \
    do {                                                                                                               \
        static bool is_shown;                                                                                          \
        dump_once(&is_shown, name, &with_room, sizeof with_room.of, DUMP_ROOM_BYTES);                                  \
    } while (0)
