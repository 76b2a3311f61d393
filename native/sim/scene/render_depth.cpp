#include "noise.h"
#include "trace.h"

#include <algorithm>
#include <cmath>

namespace ml2sim {
namespace {

constexpr float kCountsAt1m = 1000; ///< From white paper that faces the camera, at the exposure below.
constexpr float kCountsExposure_us = 1600;
constexpr float kMostCounts = 6000;
constexpr float kAmbientCounts = 40; ///< From white paper in the light of the room.
constexpr float kEdge_m = 0.05f;     ///< Between neighbours on different surfaces.

/** The surfaces that the rays of one frame met, by pixel. */
struct Echoes {
    std::vector<float> distance_m;
    std::vector<int32_t> surface;
    std::vector<float> luma;
    std::vector<float> facing; ///< Cosine of the angle of incidence.
};

Echoes listen(const Scene &scene, const RayTable &rays, const Pose &camera) {
    const Surfaces &surfaces = scene.surfaces();
    const size_t pixels = rays.x.size();
    Echoes echoes;
    echoes.distance_m.resize(pixels);
    echoes.surface.resize(pixels);
    echoes.luma.resize(pixels);
    echoes.facing.resize(pixels);
    Block block;
    for (size_t first = 0; first < pixels; first += kBlock) {
        const int count = int(std::min<size_t>(kBlock, pixels - first));
        aim(block, &rays.x[first], &rays.y[first], &rays.z[first], count, camera);
        trace(block, surfaces);
        shade(block, surfaces, rays.radians_per_pixel, &echoes.luma[first]);
        std::copy_n(block.distance, count, &echoes.distance_m[first]);
        std::copy_n(block.surface, count, &echoes.surface[first]);
        for (int i = 0; i < count; i++) {
            const Float3 n = surfaces.all[block.surface[i]].normal;
            echoes.facing[first + i] = -(n.x * block.x[i] + n.y * block.y[i] + n.z * block.z[i]);
        }
    }
    return echoes;
}

bool isEdge(const Echoes &echoes, size_t a, size_t b) {
    return echoes.surface[a] != echoes.surface[b] && std::abs(echoes.distance_m[a] - echoes.distance_m[b]) > kEdge_m;
}

bool isFlying(const Echoes &echoes, const RayTable &rays, uint32_t u, uint32_t v) {
    const size_t i = size_t(v) * rays.width + u;
    return (u > 0 && isEdge(echoes, i, i - 1)) || (u + 1 < rays.width && isEdge(echoes, i, i + 1)) ||
           (v > 0 && isEdge(echoes, i, i - rays.width)) || (v + 1 < rays.height && isEdge(echoes, i, i + rays.width));
}

template <class Value> void put(Value *image, size_t stride_bytes, uint32_t u, uint32_t v, Value value) {
    if (image)
        image[v * (stride_bytes / sizeof(Value)) + u] = value;
}

} // namespace

void renderDepth(const Scene &scene, const RayTable &rays, const Pose &camera, DepthRange range,
                 const DepthImages &images, Noise noise) {
    const Echoes echoes = listen(scene, rays, camera);
    std::vector<float> measured = echoes.distance_m;
    addNoise(measured.data(), int(measured.size()), noise, 0);
    for (uint32_t v = 0; v < rays.height; v++) {
        for (uint32_t u = 0; u < rays.width; u++) {
            const size_t i = size_t(v) * rays.width + u;
            const float distance = echoes.distance_m[i], albedo = echoes.luma[i] / 255;
            const float exposure = range.exposure_us / kCountsExposure_us;
            const float signal = kCountsAt1m * exposure * albedo * echoes.facing[i] / (distance * distance);
            const float ambient = kAmbientCounts * exposure * albedo;
            uint32_t flags = kDepthValid;
            if (distance < range.near_m || signal > kMostCounts)
                flags |= kDepthInvalid | kDepthSaturated;
            if (distance > range.far_m)
                flags |= kDepthInvalid | kDepthLowSignal;
            const bool isMeasured = flags == kDepthValid;
            if (isFlying(echoes, rays, u, v))
                flags |= kDepthInvalid | kDepthFlyingPixel;
            put(images.distance_m, images.stride_bytes, u, v, isMeasured ? measured[i] : 0.0f);
            put(images.confidence, images.stride_bytes, u, v, std::min(signal, kMostCounts));
            put(images.flags, images.stride_bytes, u, v, flags);
            put(images.raw, images.stride_bytes, u, v, std::min(ambient + signal, kMostCounts));
            put(images.ambient_raw, images.stride_bytes, u, v, ambient);
        }
    }
}

} // namespace ml2sim
