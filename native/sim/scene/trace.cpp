#include "trace.h"

#include "vectorized.h"

#include <cmath>

namespace ml2sim {
namespace {

Float3 narrow(Vec3 v) { return {float(v.x), float(v.y), float(v.z)}; }

} // namespace

ML2SIM_VECTORIZED
void aim(Block &block, const float *x, const float *y, const float *z, int count, const Pose &camera) {
    const Float3 right = narrow(rotate(camera.rotation, {1, 0, 0}));
    const Float3 up = narrow(rotate(camera.rotation, {0, 1, 0}));
    const Float3 back = narrow(rotate(camera.rotation, {0, 0, 1}));
    block.count = count;
    block.origin = narrow(camera.position);
    for (int i = 0; i < count; i++) {
        block.x[i] = right.x * x[i] + up.x * y[i] + back.x * z[i];
        block.y[i] = right.y * x[i] + up.y * y[i] + back.y * z[i];
        block.z[i] = right.z * x[i] + up.z * y[i] + back.z * z[i];
    }
}

ML2SIM_VECTORIZED
bool meets(const Block &block, Float3 center, float radius) {
    const Float3 to = {center.x - block.origin.x, center.y - block.origin.y, center.z - block.origin.z};
    const float square = to.x * to.x + to.y * to.y + to.z * to.z - radius * radius;
    if (square <= 0)
        return true;
    const float tangent = std::sqrt(square); // A ray that goes at least so far towards the centre meets the ball.
    int met = 0;
    for (int i = 0; i < block.count; i++) {
        met |= block.x[i] * to.x + block.y[i] * to.y + block.z[i] * to.z > tangent;
    }
    return met != 0;
}

namespace {

/** From inside, the nearest wall is the one that a ray leaves through first. */
ML2SIM_VECTORIZED
void traceWalls(Block &block) {
    const Float3 low = narrow(kRoomLow - Vec3{block.origin.x, block.origin.y, block.origin.z});
    const Float3 high = narrow(kRoomHigh - Vec3{block.origin.x, block.origin.y, block.origin.z});
    for (int i = 0; i < block.count; i++) {
        const float x = block.x[i], y = block.y[i], z = block.z[i];
        const float to_x = (x > 0 ? high.x : -low.x) / std::abs(x);
        const float to_y = (y > 0 ? high.y : -low.y) / std::abs(y);
        const float to_z = (z > 0 ? high.z : -low.z) / std::abs(z);
        const float side = to_x < to_y ? to_x : to_y;
        const int32_t wall = to_x < to_y ? (x > 0 ? kRightWall : kLeftWall) : (y > 0 ? kCeiling : kFloor);
        block.distance[i] = side < to_z ? side : to_z;
        block.surface[i] = side < to_z ? wall : (z > 0 ? kBackWall : kFrontWall);
    }
}

/** The slab method, in the box's own axes. */
ML2SIM_VECTORIZED
void traceBox(Block &block, const Box &box, int32_t first_surface) {
    const float c = box.cos_yaw, s = box.sin_yaw;
    const float dx = block.origin.x - box.center.x, dz = block.origin.z - box.center.z;
    const Float3 from = {c * dx - s * dz, block.origin.y - box.center.y, s * dx + c * dz};
    for (int i = 0; i < block.count; i++) {
        const float x = c * block.x[i] - s * block.z[i], y = block.y[i], z = s * block.x[i] + c * block.z[i];
        const float at_x = x > 0 ? from.x : -from.x, at_y = y > 0 ? from.y : -from.y, at_z = z > 0 ? from.z : -from.z;
        const float per_x = 1 / std::abs(x), per_y = 1 / std::abs(y), per_z = 1 / std::abs(z);
        const float near_x = (-box.half.x - at_x) * per_x, far_x = (box.half.x - at_x) * per_x;
        const float near_y = (-box.half.y - at_y) * per_y, far_y = (box.half.y - at_y) * per_y;
        const float near_z = (-box.half.z - at_z) * per_z, far_z = (box.half.z - at_z) * per_z;
        const float side = near_x > near_y ? near_x : near_y;
        const int32_t face = near_x > near_y ? (x > 0 ? kLeftWall : kRightWall) : (y > 0 ? kFloor : kCeiling);
        const float enter = side > near_z ? side : near_z;
        const int32_t entered = side > near_z ? face : (z > 0 ? kFrontWall : kBackWall);
        const float leave_side = far_x < far_y ? far_x : far_y;
        const float leave = leave_side < far_z ? leave_side : far_z;
        const bool isHit = (enter < leave) & (enter > 0) & (enter < block.distance[i]);
        block.distance[i] = isHit ? enter : block.distance[i];
        block.surface[i] = isHit ? first_surface + entered : block.surface[i];
    }
}

} // namespace

void trace(Block &block, const Surfaces &surfaces) {
    traceWalls(block);
    int32_t first_surface = kWallCount;
    for (const Box &box : surfaces.boxes) {
        const float radius = std::sqrt(box.half.x * box.half.x + box.half.y * box.half.y + box.half.z * box.half.z);
        if (meets(block, box.center, radius))
            traceBox(block, box, first_surface);
        first_surface += kWallCount;
    }
}

} // namespace ml2sim
