/** The inner loops of all renderers: rays in blocks that fit the first-level cache. */
#pragma once

#include "render.h"
#include "surfaces.h"

namespace ml2sim {

constexpr int kBlock = 256;

/** Up to kBlock rays from one point: where they go, and what they meet. */
struct Block {
    int count;
    Float3 origin;
    float x[kBlock]; ///< Unit directions in the world.
    float y[kBlock];
    float z[kBlock];
    float distance[kBlock];
    int32_t surface[kBlock]; ///< Index in Surfaces::all.
};

/** Sets the origin, and the directions to those of `count` rays in camera axes, given by component. */
void aim(Block &block, const float *x, const float *y, const float *z, int count, const Pose &camera);

/** Returns true if any ray meets a ball. */
bool meets(const Block &block, Float3 center, float radius);

/** Sets distances and surfaces. The origin must be inside the room. */
void trace(Block &block, const Surfaces &surfaces);

/** The luma that each ray meets, 0 to 255. `radians_per_pixel` decides how far the texture is smoothed. */
void shade(const Block &block, const Surfaces &surfaces, float radians_per_pixel, float *luma);

/** As above, in colour. */
void shade(const Block &block, const Surfaces &surfaces, float radians_per_pixel, float *red, float *green,
           float *blue);

} // namespace ml2sim
