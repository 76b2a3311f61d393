/** The virtual object of mixed reality: a glowing cube with the axes of the world and a ring, fixed in the room. */
#pragma once

#include "surfaces.h"
#include "canvas.h"

namespace ml2sim {

/**
 * The light that it adds along a ray, 0 to 1 and more; only what is nearer than `distance_m`, where the ray meets the
 * room. `way` is a unit vector.
 */
Rgb glow(Float3 from, Float3 way, float distance_m);

} // namespace ml2sim
