#include "eyes_and_hands.h"

#include <cmath>

namespace ml2sim {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kEyeFromMiddle_m = 0.032;

/** Turned about the vertical, so that -z points at a point of the same height. */
Quaternion facing(Vec3 from, Vec3 to) { return Quaternion::about({0, 1, 0}, std::atan2(from.x - to.x, from.z - to.z)); }

Vec3 seenPoint(int64_t mltime) { return transform(gazeInHead(mltime), {0, 0, -1}); }

/** Returns how much of a period has passed, from 0 to 1. */
double phase(int64_t mltime, int64_t period_s) {
    const int64_t period = period_s * 1000000000;
    return static_cast<double>(mltime % period) / static_cast<double>(period);
}

} // namespace

Pose gazeInHead(int64_t mltime) {
    return {Quaternion::about({0, 1, 0}, 10 * kPi / 180 * std::sin(2 * kPi * phase(mltime, 4))), {0, 0, 0}};
}

Pose eyeInHead(Side eye, int64_t mltime) {
    const Vec3 center = {eye == Side::Left ? -kEyeFromMiddle_m : kEyeFromMiddle_m, 0, 0};
    return {facing(center, seenPoint(mltime)), center};
}

Pose jointInHead(Side hand, uint32_t joint) {
    return {{}, {hand == Side::Left ? -0.2 : 0.2, -0.3, -0.4 - 0.01 * joint}};
}

Pose controllerInHead(int64_t mltime) {
    const double turn = std::sin(2 * kPi * phase(mltime, 2));
    return {Quaternion::about({0, 1, 0}, 0.3 * turn), {0.2, -0.3 + 0.05 * turn, -0.4}};
}

ControllerInput controllerInputAt(int64_t mltime) {
    const bool isFirstHalf = phase(mltime, 1) < 0.5;
    const double circle = 2 * kPi * phase(mltime, 4);
    ControllerInput input = {isFirstHalf, !isFirstHalf, phase(mltime, 4) < 0.75, 0, 0, 0, 0};
    input.trigger = static_cast<float>(1 - std::fabs(1 - 2 * phase(mltime, 2)));
    if (input.isTouched) {
        input.x = static_cast<float>(0.5 * std::cos(circle));
        input.y = static_cast<float>(0.5 * std::sin(circle));
        input.force = 0.25f;
    }
    return input;
}

} // namespace ml2sim
