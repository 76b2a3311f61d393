// 8-bit grey pixels to a baseline JPEG of one component (ITU-T T.81), with libjpeg's tables.
#include <stddef.h>
#include <string.h>

#include "codec.h"
#include "jpeg_dct.h"

enum {
    END_OF_BLOCK = 0,
    SIXTEEN_ZEROS = 0xf0,
    MOST_BITS_OF_DC = 9 + 11,  /**< Longest code of K.3, and bits of a difference of two means. */
    MOST_BITS_OF_AC = 16 + 10, /**< Longest code of K.5, and bits of a coefficient. */
};

/** The bytes that a scan writes. Bits are collected in 8 bytes. */
struct writer {
    uint8_t *next;
    uint64_t bits;  /**< The last used_bits are not written. */
    uint32_t count; /**< Number of bits in use. */
};

/** Returns nonzero if a byte of a word is 0xff. */
static inline uint64_t any_ff(uint64_t word) { return (~word - 0x0101010101010101u) & word & 0x8080808080808080u; }

/** Writes the high count bytes of a word. 0 follows each 0xff, which begins a marker otherwise. */
static void write_stuffed(struct writer *writer, uint64_t word, uint32_t count) {
    for (uint32_t i = 0; i < count; i++, word <<= 8) {
        uint8_t byte = (uint8_t)(word >> 56);
        *writer->next++ = byte;
        if (byte == 0xff) {
            *writer->next++ = 0;
        }
    }
}

static inline void write_word(struct writer *writer, uint64_t word) {
    if (__builtin_expect(any_ff(word) != 0, 0)) {
        write_stuffed(writer, word, 8);
    } else {
        word = __builtin_bswap64(word);
        memcpy(writer->next, &word, sizeof word);
        writer->next += sizeof word;
    }
}

/** Appends count bits, at most 32; the others of bits are 0. */
static inline void put(struct writer *writer, uint64_t bits, uint32_t count) {
    uint32_t total = writer->count + count;
    if (total <= 64) {
        writer->bits = writer->bits << count | bits;
        writer->count = total;
    } else {
        uint32_t excess = total - 64;
        write_word(writer, writer->bits << (count - excess) | bits >> excess);
        writer->bits = bits;
        writer->count = excess;
    }
}

/** Fills the last byte with ones, and ends the file. */
static uint8_t *finish(struct writer *writer) {
    uint32_t padding = -writer->count % 8;
    put(writer, (1u << padding) - 1, padding);
    if (writer->count) {
        write_stuffed(writer, writer->bits << (64 - writer->count), writer->count / 8);
    }
    *writer->next++ = 0xff;
    *writer->next++ = 0xd9;
    return writer->next;
}

static inline uint32_t bits_of(int32_t value) {
    uint32_t magnitude = (uint32_t)(value < 0 ? -value : value);
    return 32 - (uint32_t)__builtin_clz(magnitude << 1 | 1) - 1;
}

/** Appends the code, and the value in size bits: one less if it is negative (T.81, F.1.2.1). */
static inline void put_value(struct writer *writer, uint32_t code, int32_t value, uint32_t size) {
    uint32_t low = (uint32_t)(value + (value >> 31)) & ((1u << size) - 1);
    put(writer, (uint64_t)(code >> 8) << size | low, (code & 0xff) + size);
}

#define BIT(byte, i, place) (uint64_t)((byte) >> (i)&1) << (place)
#define PLACES(byte, a, b, c, d, e, f, g, h)                                                                           \
    BIT(byte, 0, a) | BIT(byte, 1, b) | BIT(byte, 2, c) | BIT(byte, 3, d) | BIT(byte, 4, e) | BIT(byte, 5, f) |        \
        BIT(byte, 6, g) | BIT(byte, 7, h)
#define PLACES_4(byte, ...)                                                                                            \
    PLACES(byte, __VA_ARGS__), PLACES(byte + 1, __VA_ARGS__), PLACES(byte + 2, __VA_ARGS__),                           \
        PLACES(byte + 3, __VA_ARGS__)
#define PLACES_16(byte, ...)                                                                                           \
    PLACES_4(byte, __VA_ARGS__), PLACES_4(byte + 4, __VA_ARGS__), PLACES_4(byte + 8, __VA_ARGS__),                     \
        PLACES_4(byte + 12, __VA_ARGS__)
#define PLACES_64(byte, ...)                                                                                           \
    PLACES_16(byte, __VA_ARGS__), PLACES_16(byte + 16, __VA_ARGS__), PLACES_16(byte + 32, __VA_ARGS__),                \
        PLACES_16(byte + 48, __VA_ARGS__)
#define PLACES_256(...)                                                                                                \
    { PLACES_64(0, __VA_ARGS__), PLACES_64(64, __VA_ARGS__), PLACES_64(128, __VA_ARGS__), PLACES_64(192, __VA_ARGS__) }

/** The places in zigzag order (T.81, figure A.6) of a row's bits. */
static const uint64_t zigzag_bits[8][256] = {
    PLACES_256(0, 1, 5, 6, 14, 15, 27, 28),     PLACES_256(2, 4, 7, 13, 16, 26, 29, 42),
    PLACES_256(3, 8, 12, 17, 25, 30, 41, 43),   PLACES_256(9, 11, 18, 24, 31, 40, 44, 53),
    PLACES_256(10, 19, 23, 32, 39, 45, 52, 54), PLACES_256(20, 22, 33, 38, 46, 51, 55, 60),
    PLACES_256(21, 34, 37, 47, 50, 56, 59, 61), PLACES_256(35, 36, 48, 49, 57, 58, 62, 63),
};

static inline uint64_t to_zigzag(uint64_t rows) {
    uint64_t bits = 0;
    for (uint32_t row = 0; row < 8; row++) {
        bits |= zigzag_bits[row][rows >> 8 * row & 0xff];
    }
    return bits;
}

struct scan {
    struct writer writer;
    struct jpeg_codes codes;
    struct jpeg_factors factors;
    uint8_t places[JPEG_COEFFICIENTS]; /**< Place in a jpeg_block of each coefficient in zigzag order. */
    int32_t mean;                      /**< Coefficient 0 of the block before. */
};

/** T.81, F.1.2: the difference of the means, then each other coefficient with the run of zeros before it. */
static inline void code_block(struct scan *scan, struct writer *writer, const struct jpeg_block *block) {
    const int16_t *values = (const int16_t *)block->columns;
    int32_t difference = values[0] - scan->mean;
    scan->mean = values[0];
    uint32_t size = bits_of(difference);
    put_value(writer, scan->codes.dc[size], difference, size);
    uint32_t before = 0;
    for (uint64_t left = to_zigzag(block->not_zero) & ~UINT64_C(1); left; left &= left - 1) {
        uint32_t place = (uint32_t)__builtin_ctzll(left);
        uint32_t run = place - before - 1;
        int32_t value = values[scan->places[place]];
        for (; run >= 16; run -= 16) {
            put(writer, scan->codes.ac[SIXTEEN_ZEROS] >> 8, scan->codes.ac[SIXTEEN_ZEROS] & 0xff);
        }
        size = bits_of(value);
        put_value(writer, scan->codes.ac[run << 4 | size], value, size);
        before = place;
    }
    if (before != JPEG_COEFFICIENTS - 1) {
        put(writer, scan->codes.ac[END_OF_BLOCK] >> 8, scan->codes.ac[END_OF_BLOCK] & 0xff);
    }
}

/** Copies a block that reaches over the right or lower edge, with the pixels of the edge beyond it. */
static void copy_edge(const ml2s_image *image, uint32_t x, uint32_t y, uint8_t block[64]) {
    for (uint32_t i = 0; i < 64; i++) {
        uint32_t row = y + i / 8 < image->height ? y + i / 8 : image->height - 1;
        uint32_t column = x + i % 8 < image->width ? x + i % 8 : image->width - 1;
        block[i] = image->data[(size_t)row * image->stride_bytes + column];
    }
}

static void code_row(struct scan *scan, const ml2s_image *image, uint32_t y) {
    struct writer writer = scan->writer; // In registers
    struct jpeg_block block;
    uint8_t edge[64];
    for (uint32_t x = 0; x < image->width; x += 8) {
        if (x + 8 <= image->width && y + 8 <= image->height) {
            const uint8_t *pixels = image->data + (size_t)y * image->stride_bytes + x;
            jpeg_transform(pixels, image->stride_bytes, &scan->factors, &block);
        } else {
            copy_edge(image, x, y, edge);
            jpeg_transform(edge, 8, &scan->factors, &block);
        }
        code_block(scan, &writer, &block);
    }
    scan->writer = writer;
}

static uint8_t *encode(const ml2s_image *image, uint8_t *output) {
    uint8_t divisors[JPEG_COEFFICIENTS];
    struct scan scan = {.writer = {.next = output + JPEG_HEADER_BYTES}};
    jpeg_divisors(image->quality, divisors);
    jpeg_write_header(output, image->width, image->height, divisors);
    jpeg_fill_factors(&scan.factors, divisors);
    jpeg_fill_codes(&scan.codes);
    for (uint32_t i = 0; i < JPEG_COEFFICIENTS; i++) {
        scan.places[i] = (uint8_t)(jpeg_zigzag[i] % 8 * 8 + jpeg_zigzag[i] / 8);
    }
    for (uint32_t y = 0; y < image->height; y += 8) {
        code_row(&scan, image, y);
    }
    return finish(&scan.writer);
}

/**
 * Coefficients other than the mean are at most 1020 (of 10 bits): half of 64 pixels are 127.5 above the middle, half as
 * much below, scaled by 1/8. Two means differ by at most 2040 (of 11 bits). A block has at most 63 such coefficients
 * and no longer codes than these, since runs of zeros take fewer bits than coefficients. Each byte can be 0xff, which
 * takes two.
 */
static uint64_t most_bytes(uint32_t width, uint32_t height) {
    const uint64_t blocks = ((uint64_t)width + 7) / 8 * (((uint64_t)height + 7) / 8);
    const uint64_t bits = blocks * (MOST_BITS_OF_DC + (JPEG_COEFFICIENTS - 1) * MOST_BITS_OF_AC);
    return JPEG_HEADER_BYTES + 2 * ((bits + 7) / 8) + 2;
}

const struct codec grey_jpeg = {
    .name = "grey_jpeg",
    .bytes_per_pixel = 1,
    .least_quality = 1,
    .most_quality = 100,
    .most_bytes = most_bytes,
    .encode = encode,
};
