/** The light of the ceiling's lamps; computed once, and multiplied into the painted surfaces. */
#pragma once

#include "canvas.h"
#include "layout.h"

#include <vector>

namespace ml2sim {

/** Darkens a painted surface to what the lamps, behind the boxes' shadows, make of it. */
void illuminate(Canvas &canvas, const Plane &plane, int surface, const std::vector<Plane> &planes,
                const std::vector<Box> &boxes);

} // namespace ml2sim
