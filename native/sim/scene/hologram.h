/** The virtual object of mixed reality: a glowing cube with the axes of the world and a ring, fixed in the room. */
#pragma once

#include "trace.h"

namespace ml2sim {

/** Adds its light, 0 to 255, to what rays see that were traced, as an additive display does. */
void addHologram(const Block &block, float *red, float *green, float *blue);

} // namespace ml2sim
