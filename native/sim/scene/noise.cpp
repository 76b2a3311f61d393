#include "noise.h"

#include "hash.h"
#include "vectorized.h"

#include <algorithm>
#include <cmath>

namespace ml2sim {
namespace {

/** The sum of four uniform bytes, made to have mean 0 and deviation 1: Gaussian to 3 sigma, and never beyond 3.5. */
inline float nearlyGaussian(uint32_t bits) {
    constexpr float kMean = 4 * 127.5f;
    constexpr float kDeviation = 147.8014f; // sqrt(4 * (256^2 - 1) / 12)
    const uint32_t sum = (bits & 255) + (bits >> 8 & 255) + (bits >> 16 & 255) + (bits >> 24);
    return (float(int32_t(sum)) - kMean) / kDeviation;
}

/** The finalizer of MurmurHash3 (Appleby, public domain). */
inline uint32_t scrambled(uint32_t n) {
    n = (n ^ (n >> 16)) * 0x85ebca6b;
    n = (n ^ (n >> 13)) * 0xc2b2ae35;
    return n ^ (n >> 16);
}

ML2SIM_VECTORIZED
void add(float *values, int count, float sigma, float sigmaOfSquare, uint32_t seed, uint32_t first) {
    for (int i = 0; i < count; i++)
        values[i] += (sigma + sigmaOfSquare * values[i] * values[i]) *
                     nearlyGaussian(scrambled(scrambled(first + uint32_t(i)) ^ seed));
}

ML2SIM_VECTORIZED
void addShot(float *values, int count, float sigma, float shot, uint32_t seed, uint32_t first) {
    for (int i = 0; i < count; i++)
        values[i] += std::sqrt(sigma * sigma + shot * std::max(values[i], 0.0f)) *
                     nearlyGaussian(scrambled(scrambled(first + uint32_t(i)) ^ seed));
}

} // namespace

void addNoise(float *values, int count, const Noise &noise, size_t first) {
    const auto seed = uint32_t(mix(noise.seed ^ mix(noise.frame)));
    if (noise.shot != 0)
        addShot(values, count, noise.sigma, noise.shot, seed, uint32_t(first));
    else if (noise.sigma != 0 || noise.sigmaOfSquare != 0)
        add(values, count, noise.sigma, noise.sigmaOfSquare, seed, uint32_t(first));
}

} // namespace ml2sim
