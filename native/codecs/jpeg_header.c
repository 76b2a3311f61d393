#include "jpeg_header.h"

#include <string.h>

const uint8_t jpeg_zigzag[JPEG_COEFFICIENTS] = {
    0,  1,  8,  16, 9,  2,  3,  10, 17, 24, 32, 25, 18, 11, 4,  5,  12, 19, 26, 33, 40, 48,
    41, 34, 27, 20, 13, 6,  7,  14, 21, 28, 35, 42, 49, 56, 57, 50, 43, 36, 29, 22, 15, 23,
    30, 37, 44, 51, 58, 59, 52, 45, 38, 31, 39, 46, 53, 60, 61, 54, 47, 55, 62, 63,
};

// Table K.1
static const uint8_t luminance[JPEG_COEFFICIENTS] = {
    16, 11, 10, 16, 24,  40,  51,  61,  //
    12, 12, 14, 19, 26,  58,  60,  55,  //
    14, 13, 16, 24, 40,  57,  69,  56,  //
    14, 17, 22, 29, 51,  87,  80,  62,  //
    18, 22, 37, 56, 68,  109, 103, 77,  //
    24, 35, 55, 64, 81,  104, 113, 92,  //
    49, 64, 78, 87, 103, 121, 120, 101, //
    72, 92, 95, 98, 112, 100, 103, 99,  //
};

enum { DIVISORS = 25, HEIGHT = 94, WIDTH = 96, DC_COUNTS = 107, AC_COUNTS = 140, LENGTHS = 16 };

// Annex B, with divisors and size left open. The Huffman tables are K.3 and K.5.
// clang-format off
static const uint8_t header[JPEG_HEADER_BYTES] = {
    0xff, 0xd8, // start
    0xff, 0xe0, 0, 16, 'J', 'F', 'I', 'F', 0, 1, 1, 0, 0, 1, 0, 1, 0, 0, // JFIF 1.1
    0xff, 0xdb, 0, 67, 0, // divisors
    [DIVISORS + JPEG_COEFFICIENTS] = 0xff, 0xc0, 0, 11, 8, 0, 0, 0, 0, 1, 1, 0x11, 0, // one component
    0xff, 0xc4, 0, 31, 0, // DC codes: number of each length, symbols
    0, 1, 5, 1, 1, 1, 1, 1, 1, 0, 0, 0, 0, 0, 0, 0,
    0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11,
    0xff, 0xc4, 0, 181, 0x10, // AC codes: number of each length, symbols
    0, 2, 1, 3, 3, 2, 4, 3, 5, 5, 4, 4, 0, 0, 1, 125,
    0x01, 0x02, 0x03, 0x00, 0x04, 0x11, 0x05, 0x12, 0x21, 0x31, 0x41, 0x06, 0x13, 0x51, 0x61, 0x07, 0x22, 0x71,
    0x14, 0x32, 0x81, 0x91, 0xa1, 0x08, 0x23, 0x42, 0xb1, 0xc1, 0x15, 0x52, 0xd1, 0xf0, 0x24, 0x33, 0x62, 0x72,
    0x82, 0x09, 0x0a, 0x16, 0x17, 0x18, 0x19, 0x1a, 0x25, 0x26, 0x27, 0x28, 0x29, 0x2a, 0x34, 0x35, 0x36, 0x37,
    0x38, 0x39, 0x3a, 0x43, 0x44, 0x45, 0x46, 0x47, 0x48, 0x49, 0x4a, 0x53, 0x54, 0x55, 0x56, 0x57, 0x58, 0x59,
    0x5a, 0x63, 0x64, 0x65, 0x66, 0x67, 0x68, 0x69, 0x6a, 0x73, 0x74, 0x75, 0x76, 0x77, 0x78, 0x79, 0x7a, 0x83,
    0x84, 0x85, 0x86, 0x87, 0x88, 0x89, 0x8a, 0x92, 0x93, 0x94, 0x95, 0x96, 0x97, 0x98, 0x99, 0x9a, 0xa2, 0xa3,
    0xa4, 0xa5, 0xa6, 0xa7, 0xa8, 0xa9, 0xaa, 0xb2, 0xb3, 0xb4, 0xb5, 0xb6, 0xb7, 0xb8, 0xb9, 0xba, 0xc2, 0xc3,
    0xc4, 0xc5, 0xc6, 0xc7, 0xc8, 0xc9, 0xca, 0xd2, 0xd3, 0xd4, 0xd5, 0xd6, 0xd7, 0xd8, 0xd9, 0xda, 0xe1, 0xe2,
    0xe3, 0xe4, 0xe5, 0xe6, 0xe7, 0xe8, 0xe9, 0xea, 0xf1, 0xf2, 0xf3, 0xf4, 0xf5, 0xf6, 0xf7, 0xf8, 0xf9, 0xfa,
    0xff, 0xda, 0, 8, 1, 1, 0, 0, 63, 0, // coded blocks
};
// clang-format on

void jpeg_divisors(uint32_t quality, uint8_t divisors[JPEG_COEFFICIENTS]) {
    // jpeg_quality_scaling of libjpeg
    uint32_t percent = quality < 50 ? 5000 / quality : 200 - 2 * quality;
    for (uint32_t i = 0; i < JPEG_COEFFICIENTS; i++) {
        uint32_t divisor = (luminance[i] * percent + 50) / 100;
        divisors[i] = (uint8_t)(divisor < 1 ? 1 : divisor > 255 ? 255 : divisor);
    }
}

void jpeg_write_header(uint8_t *output, uint32_t width, uint32_t height, const uint8_t divisors[JPEG_COEFFICIENTS]) {
    memcpy(output, header, sizeof header);
    for (uint32_t i = 0; i < JPEG_COEFFICIENTS; i++) {
        output[DIVISORS + i] = divisors[jpeg_zigzag[i]];
    }
    output[HEIGHT] = (uint8_t)(height >> 8);
    output[HEIGHT + 1] = (uint8_t)height;
    output[WIDTH] = (uint8_t)(width >> 8);
    output[WIDTH + 1] = (uint8_t)width;
}

/** Annex C: codes of each length are consecutive. The symbols follow the counts. */
static void fill(uint32_t *codes, const uint8_t *counts) {
    const uint8_t *symbol = counts + LENGTHS;
    uint32_t code = 0;
    for (uint32_t length = 1; length <= LENGTHS; length++, code <<= 1) {
        for (uint32_t i = 0; i < counts[length - 1]; i++) {
            codes[*symbol++] = code++ << 8 | length;
        }
    }
}

void jpeg_fill_codes(struct jpeg_codes *codes) {
    fill(codes->dc, header + DC_COUNTS);
    fill(codes->ac, header + AC_COUNTS);
}
