/**
 * The lenses of the simulated cameras. Rays are in camera axes (x right, y up, looking along -z); pixels have their
 * centres at integer coordinates, (0, 0) the centre of the first, u right, v down, as in OpenCV.
 */
#pragma once

#include "geometry.h"

#include <cstdint>
#include <optional>

namespace ml2sim {

struct Pixel {
    double u = 0;
    double v = 0;
};

/** The common properties of all cameras. */
struct Sensor {
    uint32_t width = 0; ///< Pixels, as all below.
    uint32_t height = 0;
    double fx = 0;
    double fy = 0;
    double cx = 0;
    double cy = 0;
};

/** The world cameras: equidistant with four coefficients, then tangential (two stages; not OpenCV's fisheye). */
struct FisheyeTangential : Sensor {
    double k[4] = {};
    double p1 = 0;
    double p2 = 0;

    /** Nothing when the point is farther than 1.45 rad from the optical axis. `ray` need not be a unit vector. */
    std::optional<Pixel> project(Vec3 ray) const;
    /** The unit ray, right to 1e-10, of a pixel in the image or some pixels beside it. */
    Vec3 unproject(Pixel pixel) const;
};

/** Depth and colour: OpenCV's model of five coefficients, ROS plumb_bob. */
struct PlumbBob : Sensor {
    double k1 = 0;
    double k2 = 0;
    double p1 = 0;
    double p2 = 0;
    double k3 = 0;

    /** Nothing when the point is farther than 1.2 rad from the optical axis. `ray` need not be a unit vector. */
    std::optional<Pixel> project(Vec3 ray) const;
    /** The unit ray, right to 1e-10, of a pixel in the image or some pixels beside it. */
    Vec3 unproject(Pixel pixel) const;
};

} // namespace ml2sim
