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
void addColorNoise(Colors &colors, int count, Noise noise, size_t first) {
    for (float *channel : {colors.red, colors.green, colors.blue}) {
        addNoise(channel, count, noise, first);
        noise.seed++;
    }
}

inline uint8_t byte(float value) { return uint8_t(int(std::min(std::max(value, 0.0f), 255.0f) + 0.5f)); }

ML2SIM_VECTORIZED
void toBytes(const Colors &colors, int count, uint8_t *rgb) {
    for (int i = 0; i < count; i++) {
        rgb[3 * i] = byte(colors.red[i]);
        rgb[3 * i + 1] = byte(colors.green[i]);
        rgb[3 * i + 2] = byte(colors.blue[i]);
    }
}

} // namespace

void renderColor(const Scene &scene, const RayTable &rays, const Pose &camera, bool hologram, uint8_t *rgb,
                 size_t stride_bytes, Noise noise) {
    Block block;
    Colors colors;
    for (uint32_t v = 0; v < rays.height; v++) {
        for (uint32_t u = 0; u < rays.width; u += kBlock) {
            const int count = int(std::min<uint32_t>(kBlock, rays.width - u));
            const size_t first = size_t(v) * rays.width + u;
            aim(block, &rays.x[first], &rays.y[first], &rays.z[first], count, camera);
            trace(block, scene.surfaces());
            shade(block, scene.surfaces(), rays.radians_per_pixel, colors.red, colors.green, colors.blue);
            if (hologram) addHologram(block, colors.red, colors.green, colors.blue);
            addColorNoise(colors, count, noise, first);
            toBytes(colors, count, rgb + v * stride_bytes + 3 * u);
        }
    }
}

} // namespace ml2sim
