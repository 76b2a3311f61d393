#include "hologram.h"

#include <algorithm>
#include <cmath>

namespace ml2sim {
namespace {

constexpr Float3 kCenter = {0.05f, -0.10f, -1.75f};
constexpr float kReach_m = 0.55f; ///< Nothing of it, halo included, is farther from its centre.
constexpr float kHalfCube_m = 0.17f;
constexpr float kAxis_m = 0.30f;
constexpr float kRing_m = 0.36f;
constexpr float kCore_m = 0.005f; ///< Half width of a line; its halo is wider.
constexpr float kHalo_m = 0.022f;
constexpr Rgb kCubeColor = {0.10f, 0.85f, 1.00f};
constexpr Rgb kRingColor = {1.00f, 0.35f, 0.85f};

float dot(Float3 a, Float3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
Float3 sum(Float3 a, float s, Float3 b) { return {a.x + s * b.x, a.y + s * b.y, a.z + s * b.z}; }
Float3 minus(Float3 a, Float3 b) { return sum(a, -1, b); }

/** A ray in the object's own frame, and where the room ends it. */
struct Ray {
    Float3 from, way;
    float end_m;

    Float3 at(float t) const { return sum(from, t, way); }
    float nearest(Float3 point) const { return dot(minus(point, from), way); }
};

float lineGlow(const Ray &ray, Float3 point) {
    const float t = ray.nearest(point);
    if (t <= 0 || t > ray.end_m) return 0;
    const Float3 gap = minus(point, ray.at(t));
    const float square = dot(gap, gap);
    return std::exp(-square / (kCore_m * kCore_m)) + 0.22f * std::exp(-std::sqrt(square) / kHalo_m);
}

/** The point of the segment from a along `edge` that the ray passes closest. */
Float3 nearestOfSegment(const Ray &ray, Float3 a, Float3 edge) {
    const Float3 offset = minus(ray.from, a);
    const float along = dot(ray.way, edge), square = dot(edge, edge);
    const float s = (dot(edge, offset) - along * dot(ray.way, offset)) / std::max(square - along * along, 1e-9f);
    return sum(a, std::clamp(s, 0.0f, 1.0f), edge);
}

/** Of the ring about y: by going from ray to ring and back. */
Float3 nearestOfRing(const Ray &ray) {
    Float3 point = ray.at(std::abs(ray.way.y) > 0.05f ? -ray.from.y / ray.way.y : ray.nearest({0, 0, 0}));
    for (int step = 0; step < 4; step++) {
        const float scale = kRing_m / std::max(std::hypot(point.x, point.z), 1e-6f);
        const Float3 onRing = {scale * point.x, 0, scale * point.z};
        if (step == 3) return onRing;
        point = ray.at(ray.nearest(onRing));
    }
    return point;
}

float cubeEdges(const Ray &ray) {
    constexpr float h = kHalfCube_m;
    float light = 0;
    for (int n = 0; n < 4; n++) {
        const float a = n & 1 ? h : -h, b = n & 2 ? h : -h;
        light += lineGlow(ray, nearestOfSegment(ray, {-h, a, b}, {2 * h, 0, 0}));
        light += lineGlow(ray, nearestOfSegment(ray, {a, -h, b}, {0, 2 * h, 0}));
        light += lineGlow(ray, nearestOfSegment(ray, {a, b, -h}, {0, 0, 2 * h}));
    }
    return light;
}

/** Metres of the ray inside the cube, which is filled with thin mist. */
float lengthInCube(const Ray &ray) {
    const float from[] = {ray.from.x, ray.from.y, ray.from.z}, way[] = {ray.way.x, ray.way.y, ray.way.z};
    float enter = 0, leave = ray.end_m;
    for (int axis = 0; axis < 3; axis++) {
        const float a = (-kHalfCube_m - from[axis]) / way[axis], b = (kHalfCube_m - from[axis]) / way[axis];
        enter = std::max(enter, std::min(a, b));
        leave = std::min(leave, std::max(a, b));
    }
    return std::max(0.0f, leave - enter);
}

void add(Rgb &light, float strength, Rgb color) {
    light = {light.r + strength * color.r, light.g + strength * color.g, light.b + strength * color.b};
}

} // namespace

Rgb glow(Float3 from, Float3 way, float distance_m) {
    const Ray ray = {minus(from, kCenter), way, distance_m};
    const Float3 gap = ray.at(ray.nearest({0, 0, 0}));
    if (dot(gap, gap) > kReach_m * kReach_m) return {};
    Rgb light = {};
    add(light, cubeEdges(ray) + 0.9f * lengthInCube(ray), kCubeColor);
    add(light, lineGlow(ray, nearestOfRing(ray)), kRingColor);
    add(light, lineGlow(ray, nearestOfSegment(ray, {}, {kAxis_m, 0, 0})), {1, 0.15f, 0.1f});
    add(light, lineGlow(ray, nearestOfSegment(ray, {}, {0, kAxis_m, 0})), {0.2f, 1, 0.2f});
    add(light, lineGlow(ray, nearestOfSegment(ray, {}, {0, 0, kAxis_m})), {0.25f, 0.35f, 1});
    return light;
}

} // namespace ml2sim
