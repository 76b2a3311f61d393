// The forward transform of Arai, Agui and Nakajima, "A fast DCT-SQ scheme for images", IEICE Transactions E71 (1988),
// as in T.81's literature: five multiplications per line, the rest of the scaling is part of the division by the
// divisors. Four columns are transformed at a time.
#include "jpeg_dct.h"

#include <string.h>

/** cos(k * pi / 16) * sqrt(2), 1 for k = 0: the scaling that the transform leaves to the factors. */
static const float scaling[8] = {
    1.0f, 1.387039845f, 1.306562965f, 1.175875602f, 1.0f, 0.785694958f, 0.541196100f, 0.275899379f,
};

void jpeg_fill_factors(struct jpeg_factors *factors, const uint8_t divisors[JPEG_COEFFICIENTS]) {
    for (uint32_t row = 0; row < 8; row++) {
        for (uint32_t column = 0; column < 8; column++) {
            factors->columns[column][row / 4][row % 4] =
                1.0f / (scaling[row] * scaling[column] * 8.0f * (float)divisors[8 * row + column]);
        }
    }
}

/** Transforms the lines of lanes v[0][half] to v[7][half]. */
static inline void transform_lines(float4 v[8][2], uint32_t half) {
    float4 sum0 = v[0][half] + v[7][half], difference0 = v[0][half] - v[7][half];
    float4 sum1 = v[1][half] + v[6][half], difference1 = v[1][half] - v[6][half];
    float4 sum2 = v[2][half] + v[5][half], difference2 = v[2][half] - v[5][half];
    float4 sum3 = v[3][half] + v[4][half], difference3 = v[3][half] - v[4][half];

    float4 even0 = sum0 + sum3, even3 = sum0 - sum3, even1 = sum1 + sum2, even2 = sum1 - sum2;
    float4 rotated = (even2 + even3) * 0.707106781f; // cos(pi / 4)
    v[0][half] = even0 + even1;
    v[4][half] = even0 - even1;
    v[2][half] = even3 + rotated;
    v[6][half] = even3 - rotated;

    float4 odd0 = difference3 + difference2, odd1 = difference2 + difference1, odd2 = difference1 + difference0;
    float4 shared = (odd0 - odd2) * 0.382683433f; // cos(3 pi / 8)
    float4 low = odd0 * 0.541196100f + shared;    // cos(pi / 8) - cos(3 pi / 8)
    float4 high = odd2 * 1.306562965f + shared;   // cos(pi / 8) + cos(3 pi / 8)
    float4 middle = odd1 * 0.707106781f;
    float4 plus = difference0 + middle, minus = difference0 - middle;
    v[5][half] = minus + low;
    v[3][half] = minus - low;
    v[1][half] = plus + high;
    v[7][half] = plus - high;
}

/** Transposes the 4 x 4 values of from, in rows first to first + 3 and one half. */
static inline void transpose(const float4 from[8][2], float4 to[8][2], uint32_t first, uint32_t half) {
    const float4 a = from[first][half], b = from[first + 1][half], c = from[first + 2][half], d = from[first + 3][half];
    const float4 ab01 = __builtin_shufflevector(a, b, 0, 4, 1, 5), ab23 = __builtin_shufflevector(a, b, 2, 6, 3, 7);
    const float4 cd01 = __builtin_shufflevector(c, d, 0, 4, 1, 5), cd23 = __builtin_shufflevector(c, d, 2, 6, 3, 7);
    to[4 * half][first / 4] = __builtin_shufflevector(ab01, cd01, 0, 1, 4, 5);
    to[4 * half + 1][first / 4] = __builtin_shufflevector(ab01, cd01, 2, 3, 6, 7);
    to[4 * half + 2][first / 4] = __builtin_shufflevector(ab23, cd23, 0, 1, 4, 5);
    to[4 * half + 3][first / 4] = __builtin_shufflevector(ab23, cd23, 2, 3, 6, 7);
}

static inline float4 load(const uint8_t *pixels) {
    bytes4 bytes;
    memcpy(&bytes, pixels, sizeof bytes);
    return __builtin_convertvector(bytes, float4);
}

static inline short8 quantise(const float4 values[2], const float4 factors[2]) {
    // A sum with 1.5 * 2^23 ends with the nearest integer.
    const int4 low = (int4)(values[0] * factors[0] + 12582912.0f), high = (int4)(values[1] * factors[1] + 12582912.0f);
    return __builtin_shufflevector((short8)low, (short8)high, 0, 2, 4, 6, 8, 10, 12, 14);
}

void jpeg_transform(const uint8_t *pixels, size_t stride_bytes, const struct jpeg_factors *factors,
                    struct jpeg_block *block) {
    float4 rows[8][2], columns[8][2];
    for (uint32_t half = 0; half < 2; half++) {
        for (uint32_t row = 0; row < 8; row++) {
            rows[row][half] = load(pixels + row * stride_bytes + 4 * half);
        }
        transform_lines(rows, half);
        transpose(rows, columns, 0, half);
        transpose(rows, columns, 4, half);
    }
    transform_lines(columns, 0);
    transform_lines(columns, 1);
    // T.81 subtracts 128 from each pixel, which changes the mean alone.
    columns[0][0] -= (float4){128 * 64, 0, 0, 0};
    short8 bits = {0};
    for (uint32_t column = 0; column < 8; column++) {
        short8 values = quantise(columns[column], factors->columns[column]);
        block->columns[column] = values;
        bits |= (values != 0) & (int16_t)(1 << column);
    }
    const bytes8 bits_of_rows = __builtin_convertvector(bits, bytes8);
    memcpy(&block->not_zero, &bits_of_rows, sizeof bits_of_rows);
}
