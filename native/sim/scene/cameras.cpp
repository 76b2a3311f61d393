#include "cameras.h"

#include <algorithm>
#include <stdexcept>

namespace ml2sim {
namespace {

constexpr double kPi = 3.14159265358979323846;

/** Yaw to the left, then pitch down. */
Pose turned(Vec3 position, double yaw_degrees, double pitch_degrees) {
    const Quaternion yaw = Quaternion::about({0, 1, 0}, yaw_degrees * kPi / 180);
    const Quaternion pitch = Quaternion::about({1, 0, 0}, -pitch_degrees * kPi / 180);
    return {yaw * pitch, position};
}

template <class Lens> double degreesAcross(const Lens &lens) {
    const Vec3 left = lens.unproject({-0.5, lens.cy});
    const Vec3 right = lens.unproject({lens.width - 0.5, lens.cy});
    return std::acos(dot(left, right)) * 180 / kPi;
}

} // namespace

Pose mount(Camera camera) {
    switch (camera) {
    case Camera::WorldLeft:
        return turned({-0.075, 0.000, -0.045}, 40, 10);
    case Camera::WorldCenter:
        return turned({0.000, 0.020, -0.070}, 0, 5);
    case Camera::WorldRight:
        return turned({0.075, 0.000, -0.045}, -40, 10);
    case Camera::Depth:
        return turned({0.014, 0.022, -0.074}, 0, 15);
    case Camera::Color:
        return turned({-0.012, 0.020, -0.072}, 0, 5);
    }
    throw std::invalid_argument("no such camera");
}

Pose mount(Imu imu) {
    switch (imu) {
    case Imu::Left:
        return turned({-0.070, 0.010, -0.020}, 12, 3);
    case Imu::Right:
        return turned({0.070, 0.010, -0.020}, -12, 3);
    case Imu::ComputePack:
        return turned({-0.200, -0.700, 0.050}, 90, 0);
    }
    throw std::invalid_argument("no such inertial unit");
}

FisheyeTangential worldLens(double p1, double p2) {
    return {{1016, 1016, 582.0, 581.4, 506.3, 509.8}, {0.012, -0.006, 0.002, -0.0004}, p1, p2};
}

PlumbBob depthLens() { return {{544, 480, 354.5, 342.8, 270.7, 241.2}, -0.03, 0.01, 2e-4, -3e-4, -0.001}; }

PlumbBob colorLens(uint32_t width, uint32_t height) {
    constexpr Sensor whole = {4096, 3072, 2668.0, 2666.5, 2051.4, 1530.2};
    const double scale = std::max(double(width) / whole.width, double(height) / whole.height);
    // Pixel centres are integers, so a sensor's edge is at -0.5: scaling turns about that corner.
    const auto centre = [scale](double at, uint32_t from, uint32_t to) {
        return (at + 0.5) * scale - 0.5 - (from * scale - to) / 2;
    };
    const Sensor cut = {width,
                        height,
                        whole.fx * scale,
                        whole.fy * scale,
                        centre(whole.cx, whole.width, width),
                        centre(whole.cy, whole.height, height)};
    return {cut, 0.03, -0.02, 1e-4, 2e-4, 0.003};
}

double fovDegrees(const FisheyeTangential &lens) { return degreesAcross(lens); }
double fovDegrees(const PlumbBob &lens) { return degreesAcross(lens); }

} // namespace ml2sim
