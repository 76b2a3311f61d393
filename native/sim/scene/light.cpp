#include "light.h"

#include <algorithm>

#include "paint.h"

namespace ml2sim {
namespace {

constexpr float kStep_m = 0.064f; ///< Between the spots where light is computed; it is smooth between them.
constexpr int kLampSamples = 3;   ///< Per side of a lamp: shadows have soft edges.
constexpr float kLampPower = 5.0f;
constexpr float kAmbient = 0.30f;
constexpr float kCornerDepth_m = 0.22f;
constexpr float kCornerShade = 0.30f;

/** Lambert's law over a grid of points on each lamp. */
float lampLight(Vec3 point, Vec3 normal, const Plane &ceiling, const std::vector<Box> &boxes) {
    double light = 0;
    for (const Rectangle &lamp : lamps()) {
        for (int n = 0; n < kLampSamples * kLampSamples; n++) {
            const double across = lamp.left + lamp.width * (n % kLampSamples + 0.5) / kLampSamples;
            const double down = lamp.top + lamp.height * (n / kLampSamples + 0.5) / kLampSamples;
            const Vec3 source = ceiling.origin + across * ceiling.across + down * ceiling.down;
            const Vec3 way = source - point;
            const double square = dot(way, way);
            const double facing = dot(way, normal) * -dot(way, ceiling.normal) / (square * square);
            if (facing <= 0)
                continue;
            bool hidden = false;
            for (const Box &box : boxes)
                hidden = hidden || isBetween(box, point, source);
            if (!hidden)
                light += facing * lamp.width * lamp.height;
        }
    }
    return kLampPower * float(light) / (kLampSamples * kLampSamples) / 3.1415927f;
}

/** Less light comes into corners. */
float openness(Spot spot, const Plane &plane, int surface) {
    const float width = float(plane.width_m), height = float(plane.height_m);
    const float edge = std::min(std::min(spot.x, width - spot.x), std::min(spot.y, height - spot.y));
    const bool isBox = surface >= kWallCount;
    const float toFloor = isBox ? height - spot.y : edge;
    return 1 - kCornerShade * std::exp(-toFloor / kCornerDepth_m);
}

float lightAt(Spot spot, const Plane &plane, int surface, const Plane &ceiling, const std::vector<Box> &boxes) {
    const Vec3 point = plane.origin + spot.x * plane.across + spot.y * plane.down + 1e-3 * plane.normal;
    return (kAmbient + lampLight(point, plane.normal, ceiling, boxes)) * openness(spot, plane, surface);
}

/** Returns a camera's exposure of light: bright parts are compressed, so that nothing but lamps saturates. */
float exposed(float light) { return 1.5f * light / (0.45f + light); }

} // namespace

void illuminate(Canvas &canvas, const Plane &plane, int surface, const std::vector<Plane> &planes,
                const std::vector<Box> &boxes) {
    const int columns = int(plane.width_m / kStep_m) + 2;
    const int rows = int(plane.height_m / kStep_m) + 2;
    std::vector<float> light(size_t(columns) * rows);
    for (int n = 0; n < columns * rows; n++) {
        const Spot spot = {std::min(n % columns * kStep_m, float(plane.width_m)),
                           std::min(n / columns * kStep_m, float(plane.height_m))};
        light[n] = exposed(lightAt(spot, plane, surface, planes[kCeiling], boxes));
    }
    for (int row = 0; row < canvas.height(); row++) {
        for (int column = 0; column < canvas.width(); column++) {
            const Spot spot = canvas.centerOf(column, row);
            const float x = spot.x / kStep_m, y = spot.y / kStep_m;
            const float *near = &light[size_t(y) * columns + size_t(x)];
            const float fx = x - std::floor(x), fy = y - std::floor(y);
            const float above = near[0] + fx * (near[1] - near[0]);
            const float below = near[columns] + fx * (near[columns + 1] - near[columns]);
            canvas.at(column, row) = (above + fy * (below - above)) * canvas.at(column, row);
        }
    }
}

} // namespace ml2sim
