#include "eyes_and_hands.h"

#include <cmath>

namespace ml2sim {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kEyeFromMiddle_m = 0.032;

constexpr double kRaised_rad = kPi / 3;
constexpr Vec3 kWrist = {0.2, -0.3, -0.4};
/** From the wrist of a right hand in m, before it is raised: x right, y up, palm down, fingers bent a little. */
constexpr Vec3 kJoints[] = {
    // palm, wrist
    {-0.002, 0.002, -0.055},
    {0, 0, 0},
    // thumb
    {-0.022, -0.005, -0.020},
    {-0.045, -0.012, -0.050},
    {-0.062, -0.018, -0.080},
    {-0.072, -0.022, -0.104},
    // index
    {-0.016, 0.000, -0.028},
    {-0.026, 0.004, -0.092},
    {-0.030, -0.006, -0.130},
    {-0.032, -0.020, -0.150},
    {-0.033, -0.036, -0.168},
    // middle
    {-0.004, 0.002, -0.026},
    {-0.004, 0.006, -0.094},
    {-0.004, -0.006, -0.137},
    {-0.004, -0.022, -0.160},
    {-0.004, -0.040, -0.179},
    // ring
    {0.007, 0.001, -0.025},
    {0.016, 0.003, -0.088},
    {0.020, -0.009, -0.127},
    {0.021, -0.025, -0.148},
    {0.021, -0.042, -0.166},
    // little
    {0.017, -0.002, -0.025},
    {0.033, -0.003, -0.079},
    {0.040, -0.012, -0.108},
    {0.042, -0.023, -0.123},
    {0.043, -0.037, -0.138},
};

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
    const Vec3 from = rotate(Quaternion::about({1, 0, 0}, kRaised_rad), kJoints[joint]);
    const double x = kWrist.x + from.x;
    return {{}, {hand == Side::Left ? -x : x, kWrist.y + from.y, kWrist.z + from.z}};
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
