#include "hologram.h"

#include "vectorized.h"

#include <algorithm>
#include <cmath>

namespace ml2sim {
namespace {

constexpr Float3 kCenter = {0.05f, -0.10f, -1.75f};
constexpr float kReach_m = 0.55f; ///< Nothing of it can be seen farther from its centre.
constexpr float kHalfCube_m = 0.17f;
constexpr float kAxis_m = 0.30f;
constexpr float kRing_m = 0.36f;
constexpr float kCore_m = 0.007f; ///< Half width of a line.
constexpr float kHalo_m = 0.025f;
constexpr float kHaloStrength = 0.2f;
constexpr float kMist_per_m = 0.9f; ///< Strength of the mist that fills the cube.

struct Color {
    float r, g, b;
};
constexpr Color kCubeColor = {0.10f, 0.85f, 1.00f};
constexpr Color kRingColor = {1.00f, 0.35f, 0.85f};

struct Line {
    Float3 from, edge;
    Color color;
};
constexpr float h = kHalfCube_m;
constexpr Line kLines[] = {
    {{-h, -h, -h}, {2 * h, 0, 0}, kCubeColor},       {{-h, h, -h}, {2 * h, 0, 0}, kCubeColor},
    {{-h, -h, h}, {2 * h, 0, 0}, kCubeColor},        {{-h, h, h}, {2 * h, 0, 0}, kCubeColor},
    {{-h, -h, -h}, {0, 2 * h, 0}, kCubeColor},       {{h, -h, -h}, {0, 2 * h, 0}, kCubeColor},
    {{-h, -h, h}, {0, 2 * h, 0}, kCubeColor},        {{h, -h, h}, {0, 2 * h, 0}, kCubeColor},
    {{-h, -h, -h}, {0, 0, 2 * h}, kCubeColor},       {{h, -h, -h}, {0, 0, 2 * h}, kCubeColor},
    {{-h, h, -h}, {0, 0, 2 * h}, kCubeColor},        {{h, h, -h}, {0, 0, 2 * h}, kCubeColor},
    {{0, 0, 0}, {kAxis_m, 0, 0}, {1, 0.15f, 0.1f}},  {{0, 0, 0}, {0, kAxis_m, 0}, {0.2f, 1, 0.2f}},
    {{0, 0, 0}, {0, 0, kAxis_m}, {0.25f, 0.35f, 1}},
};

struct Light {
    float red[kBlock], green[kBlock], blue[kBlock];
};

inline float dot(Float3 a, Float3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Float3 sum(Float3 a, float s, Float3 b) { return {a.x + s * b.x, a.y + s * b.y, a.z + s * b.z}; }
inline Float3 minus(Float3 a, Float3 b) { return sum(a, -1, b); }
inline float clamped(float value, float low, float high) { return std::min(std::max(value, low), high); }

/** The light along a ray in the object's frame that passes `point`, unless the room ends it before. */
inline float glow(Float3 from, Float3 way, float end_m, Float3 point) {
    const float t = dot(minus(point, from), way);
    const Float3 gap = minus(point, sum(from, t, way));
    const float square = dot(gap, gap);
    const float core = 1 + square / (kCore_m * kCore_m), halo = 1 + square / (kHalo_m * kHalo_m);
    const float light = 1 / (core * core) + kHaloStrength / (halo * halo);
    return ((t > 0) & (t < end_m)) ? light : 0;
}

inline void add(Light &light, int i, float strength, Color color) {
    light.red[i] += strength * color.r;
    light.green[i] += strength * color.g;
    light.blue[i] += strength * color.b;
}

ML2SIM_VECTORIZED
void addLine(const Block &block, Light &light, const Line &line) {
    const Float3 from = minus(block.origin, kCenter), offset = minus(from, line.from);
    const float square = dot(line.edge, line.edge), beside = dot(line.edge, offset);
    for (int i = 0; i < block.count; i++) {
        const Float3 way = {block.x[i], block.y[i], block.z[i]};
        const float along = dot(way, line.edge);
        const float s = (beside - along * dot(way, offset)) / std::max(square - along * along, 1e-9f);
        const Float3 nearest = sum(line.from, clamped(s, 0, 1), line.edge);
        add(light, i, glow(from, way, block.distance[i], nearest), line.color);
    }
}

/** The ring's nearest point is found by going from ray to ring and back. */
ML2SIM_VECTORIZED
void addRing(const Block &block, Light &light) {
    const Float3 from = minus(block.origin, kCenter);
    for (int i = 0; i < block.count; i++) {
        const Float3 way = {block.x[i], block.y[i], block.z[i]};
        const float level = std::abs(way.y) > 0.05f ? -from.y / way.y : -dot(from, way);
        Float3 point = sum(from, level, way);
        for (int step = 0; step < 4; step++) {
            const float scale = kRing_m / std::sqrt(std::max(point.x * point.x + point.z * point.z, 1e-9f));
            const Float3 on_ring = {scale * point.x, 0, scale * point.z};
            point = step < 3 ? sum(from, dot(minus(on_ring, from), way), way) : on_ring;
        }
        add(light, i, glow(from, way, block.distance[i], point), kRingColor);
    }
}

/** As strong as the way of the ray in the cube is long. */
ML2SIM_VECTORIZED
void addMist(const Block &block, Light &light) {
    const Float3 from = minus(block.origin, kCenter);
    for (int i = 0; i < block.count; i++) {
        const float x = 1 / std::abs(block.x[i]), y = 1 / std::abs(block.y[i]), z = 1 / std::abs(block.z[i]);
        const float at_x = block.x[i] > 0 ? from.x : -from.x, at_y = block.y[i] > 0 ? from.y : -from.y;
        const float at_z = block.z[i] > 0 ? from.z : -from.z;
        const float enter = std::max(std::max((-h - at_x) * x, (-h - at_y) * y), std::max((-h - at_z) * z, 0.0f));
        const float leave =
            std::min(std::min((h - at_x) * x, (h - at_y) * y), std::min((h - at_z) * z, block.distance[i]));
        add(light, i, kMist_per_m * std::max(leave - enter, 0.0f), kCubeColor);
    }
}

/** Light is added until white is reached. */
ML2SIM_VECTORIZED
void screen(float *seen, const float *light, int count) {
    for (int i = 0; i < count; i++)
        seen[i] += (255 - seen[i]) * std::min(light[i], 1.0f);
}

} // namespace

void addHologram(const Block &block, float *red, float *green, float *blue) {
    if (!meets(block, kCenter, kReach_m))
        return;
    Light light = {};
    for (const Line &line : kLines)
        addLine(block, light, line);
    addRing(block, light);
    addMist(block, light);
    screen(red, light.red, block.count);
    screen(green, light.green, block.count);
    screen(blue, light.blue, block.count);
}

} // namespace ml2sim
