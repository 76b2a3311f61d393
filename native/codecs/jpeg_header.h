/** The tables of ITU-T T.81, Annex K, and what a JPEG file begins with. */
#pragma once

#include <stdint.h>

enum {
    JPEG_HEADER_BYTES = 328,
    JPEG_COEFFICIENTS = 64, /**< In a block of 8 x 8 pixels. */
};

/** The code of a Huffman symbol: the code above, the number of its bits in the low 8 bits. */
struct jpeg_codes {
    uint32_t dc[12];  /**< By the number of bits of the difference. */
    uint32_t ac[256]; /**< By run of zeros * 16 + number of bits of the coefficient. */
};

/** Fills the divisors of a quality, 1 to 100, in the order of rows. They are those of libjpeg. */
void jpeg_divisors(uint32_t quality, uint8_t divisors[JPEG_COEFFICIENTS]);

/** Writes JPEG_HEADER_BYTES: all before the coded blocks. */
void jpeg_write_header(uint8_t *output, uint32_t width, uint32_t height, const uint8_t divisors[JPEG_COEFFICIENTS]);

/** Computes the codes of the Huffman tables in the header. */
void jpeg_fill_codes(struct jpeg_codes *codes);

/** The row-major place of each coefficient in zigzag order. */
extern const uint8_t jpeg_zigzag[JPEG_COEFFICIENTS];
