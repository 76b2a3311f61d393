#include "edges.h"
#include "noise.h"
#include "trace.h"
#include "vectorized.h"

#include <algorithm>

namespace ml2sim {
namespace {

ML2SIM_VECTORIZED
void toBytes(const float *luma, int count, float gain, uint8_t *grey) {
    for (int i = 0; i < count; i++)
        grey[i] = uint8_t(int(std::min(std::max(gain * luma[i], 0.0f), 255.0f) + 0.5f));
}

} // namespace

void renderWorld(const Scene &scene, const RayTable &rays, const Pose &camera, uint8_t *grey, size_t stride_bytes,
                 float gain, Noise noise) {
    const Surfaces &surfaces = scene.surfaces();
    Edges edges(rays);
    Block block;
    float luma[kBlock];
    for (uint32_t v = 0; v < rays.height; v++) {
        for (uint32_t u = 0; u < rays.width; u += kBlock) {
            const int count = int(std::min<uint32_t>(kBlock, rays.width - u));
            const size_t first = size_t(v) * rays.width + u;
            aim(block, &rays.x[first], &rays.y[first], &rays.z[first], count, camera);
            trace(block, surfaces);
            edges.note(block, first);
            shade(block, surfaces, rays.radians_per_pixel, luma);
            addNoise(luma, count, noise, first);
            toBytes(luma, count, gain, grey + v * stride_bytes + u);
        }
    }
    edges.forEachBlock(camera, [&](Block &finer, const std::vector<size_t> &pixels) {
        trace(finer, surfaces);
        shade(finer, surfaces, rays.radians_per_pixel, luma);
        average(luma, pixels.size());
        for (size_t n = 0; n < pixels.size(); n++) {
            addNoise(&luma[n], 1, noise, pixels[n]);
            toBytes(&luma[n], 1, gain, grey + pixels[n] / rays.width * stride_bytes + pixels[n] % rays.width);
        }
    });
}

} // namespace ml2sim
