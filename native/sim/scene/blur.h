/** The blur of a camera that turns while it is exposed. */
#pragma once

#include "render.h"

#include <vector>

namespace ml2sim {

/**
 * Replaces each of the picture's values by the mean along the way that its ray's image takes while the camera turns by
 * `turn` (radians about camera axes), half of it before and half after. How the camera moves is left out.
 */
void blur(std::vector<float> &values, const RayTable &rays, Vec3 turn);

} // namespace ml2sim
