// Depth in metres to millimetres in the format "16UC1; compressedDepth rvl" of ROS's compressed_depth_image_transport
// (codec.cpp, rvl_codec.cpp). RVL is of A. D. Wilson, "Fast lossless depth image compression", ISS 2017: runs of zeros
// and of other values take turns, each begins with its length, and a value is its difference to the one before. A
// number is written in groups of 3 bits, lowest first, each in 4 bits whose highest says that another one follows; the
// first of 8 groups is the highest of a 32-bit word.
#include <stdbool.h>
#include <stddef.h>
#include <string.h>

#include "codec.h"
#include "vectors.h"

enum {
    HEADER_BYTES = 12 + 8, /**< int32 and two floats, 0 for integers of millimetres; columns and rows. */
    CHUNK = 256,           /**< Pixels that are converted at a time. */
    SHORT_NUMBERS = 512,   /**< Numbers of at most 3 groups. */
};

struct writer {
    uint8_t *next;
    uint64_t bits;  /**< From the highest. */
    uint32_t count; /**< Number of bits in use, less than 32 between calls. */
};

/** Appends count bits, at most 32. Writes the first word in each case, and stays on it until it is full. */
static inline void put(struct writer *writer, uint64_t bits, uint32_t count) {
    writer->count += count;
    writer->bits |= bits << (64 - writer->count);
    uint32_t word = (uint32_t)(writer->bits >> 32);
    memcpy(writer->next, &word, sizeof word);
    uint32_t full = writer->count >> 5;
    writer->next += sizeof word * full;
    writer->bits <<= 32 * full;
    writer->count &= 31;
}

#define GROUPS(n)                                                                                                      \
    ((n) < 8    ? 1 << 12 | (n)                                                                                        \
     : (n) < 64 ? 2 << 12 | (8 | ((n)&7)) << 4 | (n) >> 3                                                              \
                : 3 << 12 | (8 | ((n)&7)) << 8 | (8 | ((n) >> 3 & 7)) << 4 | (n) >> 6)
#define GROUPS_8(n)                                                                                                    \
    GROUPS(n), GROUPS(n + 1), GROUPS(n + 2), GROUPS(n + 3), GROUPS(n + 4), GROUPS(n + 5), GROUPS(n + 6), GROUPS(n + 7)
#define GROUPS_64(n)                                                                                                   \
    GROUPS_8(n), GROUPS_8(n + 8), GROUPS_8(n + 16), GROUPS_8(n + 24), GROUPS_8(n + 32), GROUPS_8(n + 40),              \
        GROUPS_8(n + 48), GROUPS_8(n + 56)

/** The groups of a number, and their number in the highest 4 bits. */
static const uint16_t short_numbers[SHORT_NUMBERS] = {
    GROUPS_64(0),   GROUPS_64(64),  GROUPS_64(128), GROUPS_64(192),
    GROUPS_64(256), GROUPS_64(320), GROUPS_64(384), GROUPS_64(448),
};

static inline void put_number(struct writer *writer, uint32_t number) {
    for (; number >= SHORT_NUMBERS; number >>= 3) {
        put(writer, 8 | (number & 7), 4);
    }
    put(writer, short_numbers[number] & 0xfff, 4 * (short_numbers[number] >> 12));
}

/** Rounds to the nearest; 0 for NaN and for what is not nearest to one of 1 to 65535 mm. */
static inline int4 to_millimetres(float4 metres) {
    float4 millimetres = metres * 1000.0f;
    int4 is_valid = (millimetres > 0.0f) & (millimetres < 65535.5f);
    // A sum with 2^23 ends with the nearest integer.
    return (int4)(millimetres + 8388608.0f) & 0xffff & is_valid;
}

/** Loads up to 4 pixels; the others are 0. */
static inline float4 load(const uint8_t *pixels, uint32_t count) {
    float4 metres = {0};
    if (count >= 4) {
        memcpy(&metres, pixels, sizeof metres);
    } else {
        memcpy(&metres, pixels, count * sizeof(float));
    }
    return metres;
}

/** A place in the image. */
struct cursor {
    const ml2s_image *image;
    uint32_t row;    /**< The height of the image at its end. */
    uint32_t column; /**< Less than the width. */
};

static inline const uint8_t *pixels_at(const struct cursor *at) {
    return at->image->data + (size_t)at->row * at->image->stride_bytes + at->column * sizeof(float);
}

/** Advances by count pixels of the row. */
static inline void advance(struct cursor *at, uint32_t count) {
    at->column += count;
    if (at->column == at->image->width) {
        at->column = 0;
        at->row++;
    }
}

/** Counts the pixels of a row, of the next left ones, that are zeros or are not. */
static uint32_t run_in_row(const uint8_t *pixels, uint32_t left, bool are_zeros) {
    const int32_t unlike = are_zeros ? 0 : -1;
    for (uint32_t i = 0; i < left; i += 4) {
        int4 is_like = (to_millimetres(load(pixels + i * sizeof(float), left - i)) == 0) ^ unlike;
        uint64_t halves[2];
        memcpy(halves, &is_like, sizeof halves);
        if ((halves[0] & halves[1]) != UINT64_MAX) {
            uint32_t like = 0;
            while (like < 4 && is_like[like]) {
                like++;
            }
            return i + like; // Not beyond the row, whose missing lanes are 0.
        }
    }
    return left;
}

/** Moves past the next zeros, or values that are not 0. Returns their number. */
static uint32_t skip_run(struct cursor *at, bool are_zeros) {
    uint32_t total = 0;
    while (at->row < at->image->height) {
        uint32_t left = at->image->width - at->column;
        uint32_t run = run_in_row(pixels_at(at), left, are_zeros);
        total += run;
        advance(at, run);
        if (run < left) {
            break;
        }
    }
    return total;
}

/** Appends the next count pixels, which are not 0; previous is the last value before them. Returns the last one. */
static int32_t put_values(struct writer *writer, struct cursor *at, uint32_t count, int32_t previous) {
    struct writer local = *writer; // In registers
    int32_t values[CHUNK];
    while (count) {
        uint32_t left = at->image->width - at->column;
        uint32_t size = count < left ? count : left;
        size = size < CHUNK ? size : CHUNK;
        for (uint32_t i = 0; i < size; i += 4) {
            int4 millimetres = to_millimetres(load(pixels_at(at) + i * sizeof(float), size - i));
            memcpy(values + i, &millimetres, sizeof millimetres);
        }
        for (uint32_t i = 0; i < size; i++) {
            int32_t difference = values[i] - previous;
            previous = values[i];
            put_number(&local, (uint32_t)difference << 1 ^ (uint32_t)(difference >> 31));
        }
        advance(at, size);
        count -= size;
    }
    *writer = local;
    return previous;
}

static uint8_t *encode(const ml2s_image *image, uint8_t *output) {
    memset(output, 0, HEADER_BYTES);
    memcpy(output + 12, &image->width, sizeof image->width);
    memcpy(output + 16, &image->height, sizeof image->height);
    struct writer writer = {.next = output + HEADER_BYTES};
    struct cursor at = {.image = image};
    int32_t previous = 0;
    while (at.row < image->height) {
        put_number(&writer, skip_run(&at, true));
        struct cursor end = at;
        uint32_t count = skip_run(&end, false);
        put_number(&writer, count);
        previous = put_values(&writer, &at, count, previous);
    }
    if (writer.count) {
        put(&writer, 0, 32 - writer.count);
    }
    return writer.next;
}

/**
 * A difference is less than 2^16, with its sign of 17 bits: 6 groups. A length n above 0 has at most n groups. Only the
 * first run of zeros and the last one of values can have the length 0, which has one group. So there are at most 7
 * groups per pixel and 2 more, in whole words.
 */
static uint64_t most_bytes(uint32_t width, uint32_t height) {
    const uint64_t groups = 7 * (uint64_t)width * height + 2;
    return HEADER_BYTES + sizeof(uint32_t) * ((groups + 7) / 8);
}

const struct codec depth_rvl = {
    .name = "depth_rvl",
    .bytes_per_pixel = sizeof(float),
    .most_bytes = most_bytes,
    .encode = encode,
};
