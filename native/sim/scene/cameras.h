/**
 * The simulated headset's cameras and inertial units: plausible lenses and places, since the vendor publishes none.
 */
#pragma once

#include "lens.h"

#include <cstdint>

namespace ml2sim {

/** The cameras with a pose; mixed reality is seen through Color. */
enum class Camera { WorldLeft, WorldCenter, WorldRight, Depth, Color };

enum class Imu { Left, Right, ComputePack };

/** The image sizes of eye cameras, pixels. */
constexpr uint32_t kEyeWidth = 400;
constexpr uint32_t kEyeHeight = 400;

/** Head <- camera. */
Pose mount(Camera camera);

/** Head <- the unit's Android axes (x right, y up, z backward, turned as it is built in). The pack hangs rigidly. */
Pose mount(Imu imu);

/** 1016 x 1016, 100 x 100 degrees; the same for all three. */
FisheyeTangential worldLens(double p1 = 1e-4, double p2 = 1e-4);

/** 544 x 480, 75 x 70 degrees. */
PlumbBob depthLens();

/** The 4096 x 3072 sensor, 75 degrees wide, scaled to fill `width` x `height`, then cut at the centre. */
PlumbBob colorLens(uint32_t width, uint32_t height);

/** Degrees across, what the vendor's structures call fov. */
double fovDegrees(const FisheyeTangential &lens);
double fovDegrees(const PlumbBob &lens);

} // namespace ml2sim
