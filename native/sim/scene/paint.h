/** Paints the room's surfaces. */
#pragma once

#include "canvas.h"
#include "fiducials.h"
#include "layout.h"

#include <vector>

namespace ml2sim {

/** Metres per texel: walls and boxes fine, floor and ceiling, which carry no fiducials, coarser. */
double texelOf(int surface);

/** The ceiling's lamps, from its top left. */
const std::vector<Rectangle> &lamps();

/** The surface in its own colours, unlit, with the cards that hang on it. */
Canvas painted(const Plane &plane, int surface, const std::vector<Card> &cards, TagKind tags, uint64_t seed);

} // namespace ml2sim
