/** The room as the renderer reads it: rectangles with painted textures, and the boxes that hide them. */
#pragma once

#include <cstdint>
#include <vector>

namespace ml2sim {

constexpr int kMostLevels = 12;
/** The surfaces of the room: axis x, y, z, low then high side. Those of boxes follow in the same order. */
enum WallIndex { kLeftWall, kRightWall, kFloor, kCeiling, kFrontWall, kBackWall, kWallCount };

struct Float3 {
    float x, y, z;
};

/** A rectangle with its texture: RGB and luma of each texel in one word, a level per halving. */
struct Surface {
    Float3 origin; ///< Top left of the rectangle, and of its first texel.
    Float3 across; ///< Unit.
    Float3 down;   ///< Unit.
    Float3 normal; ///< Unit.
    float texels_per_m;
    int width; ///< Texels of level 0. Level n has a 2^n-th of it, rounded up, so that levels stay aligned.
    int height;
    int last_level;
    int offset[kMostLevels]; ///< By level, in Surfaces::texels.
};

/** Stands in the room, turned about y. */
struct Box {
    Float3 center;
    Float3 half;
    float cos_yaw;
    float sin_yaw;
};

struct Surfaces {
    std::vector<Surface> all;
    std::vector<Box> boxes;
    std::vector<uint32_t> texels; ///< R, G, B, luma from the lowest byte.
};

} // namespace ml2sim
