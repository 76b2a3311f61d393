#include "eyes_and_hands.h"

namespace ml2sim {
namespace {

constexpr double kEyeFromMiddle_m = 0.032;

/** Turned about the vertical, so that -z points at a point of the same height. */
Quaternion facing(Vec3 from, Vec3 to) { return Quaternion::about({0, 1, 0}, std::atan2(from.x - to.x, from.z - to.z)); }

Vec3 seenPoint(int64_t mltime) { return transform(gazeInHead(mltime), {0, 0, -1}); }

} // namespace

Pose gazeInHead(int64_t mltime) {
    constexpr double kPi = 3.14159265358979323846;
    const double phase = static_cast<double>(mltime % 4000000000) / 4e9;
    return {Quaternion::about({0, 1, 0}, 10 * kPi / 180 * std::sin(2 * kPi * phase)), {0, 0, 0}};
}

Pose eyeInHead(Side eye, int64_t mltime) {
    const Vec3 center = {eye == Side::Left ? -kEyeFromMiddle_m : kEyeFromMiddle_m, 0, 0};
    return {facing(center, seenPoint(mltime)), center};
}

Pose jointInHead(Side hand, uint32_t joint) {
    return {{}, {hand == Side::Left ? -0.2 : 0.2, -0.3, -0.4 - 0.01 * joint}};
}

} // namespace ml2sim
