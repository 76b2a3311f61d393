/** Numbers that look random, the same everywhere for the same seed. */
#pragma once

#include <cstdint>

namespace ml2sim {

/** The finalizer of splitmix64 (Steele, Lea, Flood 2014). */
inline uint64_t mix(uint64_t n) {
    n += 0x9e3779b97f4a7c15;
    n = (n ^ (n >> 30)) * 0xbf58476d1ce4e5b9;
    n = (n ^ (n >> 27)) * 0x94d049bb133111eb;
    return n ^ (n >> 31);
}

class Random {
  public:
    explicit Random(uint64_t seed) : state_(seed) {}

    uint64_t next() { return mix(state_++); }
    float uniform(float low, float high) { return low + (high - low) * float(next() >> 40) * 0x1p-24f; }
    int below(int count) { return int(next() % uint64_t(count)); }

  private:
    uint64_t state_;
};

} // namespace ml2sim
