#pragma once

#include <cmath>
#include <cstdint>

namespace ml2sim {

/** The hash function splitmix64. */
inline uint64_t scramble(uint64_t x) {
    x += 0x9e3779b97f4a7c15;
    x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9;
    x = (x ^ x >> 27) * 0x94d049bb133111eb;
    return x ^ x >> 31;
}

/** Returns a uniform number in (0, 1), equal for equal keys. */
inline double uniform(uint64_t key) { return (static_cast<double>(scramble(key) >> 11) + 0.5) * 0x1p-53; }

/** Returns a normal number with mean 0 and standard deviation 1, equal for equal keys. */
inline double gaussian(uint64_t key) {
    constexpr double kTau = 6.283185307179586;
    return std::sqrt(-2 * std::log(uniform(key))) * std::cos(kTau * uniform(scramble(key) ^ 0x5bd1e995));
}

} // namespace ml2sim
