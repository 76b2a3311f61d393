#include "blur.h"
#include "edges.h"
#include "noise.h"
#include "trace.h"
#include "vectorized.h"

#include <algorithm>
#include <vector>

namespace ml2sim {
namespace {

ML2SIM_VECTORIZED
void toBytes(const float *luma, int count, float gain, uint8_t *grey) {
    for (int i = 0; i < count; i++)
        grey[i] = uint8_t(int(std::min(std::max(gain * luma[i], 0.0f), 255.0f) + 0.5f));
}

} // namespace

void renderWorld(const Scene &scene, const RayTable &rays, const Pose &camera, uint8_t *grey, size_t stride_bytes,
                 const Shot &shot) {
    const Surfaces &surfaces = scene.surfaces();
    Edges edges(rays);
    Block block;
    std::vector<float> luma(rays.x.size());
    for (size_t first = 0; first < luma.size(); first += kBlock) {
        aim(block, &rays.x[first], &rays.y[first], &rays.z[first], int(std::min<size_t>(kBlock, luma.size() - first)),
            camera);
        trace(block, surfaces);
        edges.note(block, first);
        shade(block, surfaces, rays.radians_per_pixel, &luma[first]);
    }
    edges.forEachBlock(camera, [&](Block &finer, const std::vector<size_t> &pixels) {
        float finerLuma[kBlock];
        trace(finer, surfaces);
        shade(finer, surfaces, rays.radians_per_pixel, finerLuma);
        average(finerLuma, pixels.size());
        for (size_t n = 0; n < pixels.size(); n++)
            luma[pixels[n]] = finerLuma[n];
    });
    blur(luma, rays, shot.turn);
    for (uint32_t v = 0; v < rays.height; v++) {
        const size_t first = size_t(v) * rays.width;
        addNoise(&luma[first], int(rays.width), shot.noise, first);
        toBytes(&luma[first], int(rays.width), shot.gain, grey + v * stride_bytes);
    }
}

} // namespace ml2sim
