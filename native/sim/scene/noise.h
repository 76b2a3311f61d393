/** Gaussian noise, a pure function of where it falls. */
#pragma once

#include "render.h"

#include <cstddef>

namespace ml2sim {

/** Adds noise to `count` values, the first of which is number `first` of its frame. */
void addNoise(float *values, int count, const Noise &noise, size_t first);

} // namespace ml2sim
