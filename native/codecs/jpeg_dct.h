/** The transform of blocks of 8 x 8 pixels. */
#pragma once

#include <stddef.h>

#include "jpeg_header.h"
#include "vectors.h"

/** Factors of the coefficients: scaling of the transform divided by the divisors. */
struct jpeg_factors {
    float4 columns[8][2]; /**< By column, then by row. */
};

/** The quantised coefficients of a block. */
struct jpeg_block {
    short8 columns[8]; /**< By column, then by row. */
    uint64_t not_zero; /**< Bit 8 * row + column: the coefficient is not 0. */
};

void jpeg_fill_factors(struct jpeg_factors *factors, const uint8_t divisors[JPEG_COEFFICIENTS]);

/** Transforms and quantises 8 rows of 8 pixels. */
void jpeg_transform(const uint8_t *pixels, size_t stride_bytes, const struct jpeg_factors *factors,
                    struct jpeg_block *block);
