/** Textures with all their smaller levels. */
#pragma once

#include "canvas.h"
#include "layout.h"
#include "surfaces.h"

namespace ml2sim {

/** Appends the canvas and its halvings, each the mean of two by two texels, and says where they are. */
Surface addPyramid(Canvas &canvas, const Plane &plane, std::vector<uint32_t> &texels);

} // namespace ml2sim
