#include "edges.h"
#include "hologram.h"
#include "noise.h"
#include "trace.h"
#include "vectorized.h"

#include <algorithm>

namespace ml2sim {
namespace {

struct Colors {
    float red[kBlock], green[kBlock], blue[kBlock];
};

/** Each channel has noise of its own. */
void addColorNoise(Colors &colors, int begin, int count, Noise noise, size_t first) {
    for (float *channel : {colors.red, colors.green, colors.blue}) {
        addNoise(channel + begin, count, noise, first);
        noise.seed++;
    }
}

inline uint8_t byte(float value) { return uint8_t(int(std::min(std::max(value, 0.0f), 255.0f) + 0.5f)); }

ML2SIM_VECTORIZED
void toBytes(const Colors &colors, int begin, int count, uint8_t *rgb) {
    for (int i = 0; i < count; i++) {
        rgb[3 * i] = byte(colors.red[begin + i]);
        rgb[3 * i + 1] = byte(colors.green[begin + i]);
        rgb[3 * i + 2] = byte(colors.blue[begin + i]);
    }
}

void see(const Scene &scene, float radians_per_pixel, bool hologram, Block &block, Colors &colors) {
    shade(block, scene.surfaces(), radians_per_pixel, colors.red, colors.green, colors.blue);
    if (hologram)
        addHologram(block, colors.red, colors.green, colors.blue);
}

} // namespace

void renderColor(const Scene &scene, const RayTable &rays, const Pose &camera, bool hologram, uint8_t *rgb,
                 size_t stride_bytes, Noise noise) {
    Edges edges(rays);
    Block block;
    Colors colors;
    for (uint32_t v = 0; v < rays.height; v++) {
        for (uint32_t u = 0; u < rays.width; u += kBlock) {
            const int count = int(std::min<uint32_t>(kBlock, rays.width - u));
            const size_t first = size_t(v) * rays.width + u;
            aim(block, &rays.x[first], &rays.y[first], &rays.z[first], count, camera);
            trace(block, scene.surfaces());
            edges.note(block, first);
            see(scene, rays.radians_per_pixel, hologram, block, colors);
            addColorNoise(colors, 0, count, noise, first);
            toBytes(colors, 0, count, rgb + v * stride_bytes + 3 * u);
        }
    }
    edges.forEachBlock(camera, [&](Block &finer, const std::vector<size_t> &pixels) {
        trace(finer, scene.surfaces());
        see(scene, rays.radians_per_pixel, hologram, finer, colors);
        for (float *channel : {colors.red, colors.green, colors.blue})
            average(channel, pixels.size());
        for (size_t n = 0; n < pixels.size(); n++) {
            addColorNoise(colors, int(n), 1, noise, pixels[n]);
            toBytes(colors, int(n), 1, rgb + pixels[n] / rays.width * stride_bytes + pixels[n] % rays.width * 3);
        }
    });
}

} // namespace ml2sim
