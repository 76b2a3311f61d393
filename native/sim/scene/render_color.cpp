#include "blur.h"
#include "edges.h"
#include "hologram.h"
#include "noise.h"
#include "trace.h"
#include "vectorized.h"

#include <algorithm>
#include <vector>

namespace ml2sim {
namespace {

inline uint8_t byte(float value) { return uint8_t(int(std::min(std::max(value, 0.0f), 255.0f) + 0.5f)); }

ML2SIM_VECTORIZED
void toBytes(const float *red, const float *green, const float *blue, uint32_t count, float gain, uint8_t *rgb) {
    for (uint32_t i = 0; i < count; i++) {
        rgb[3 * i] = byte(gain * red[i]);
        rgb[3 * i + 1] = byte(gain * green[i]);
        rgb[3 * i + 2] = byte(gain * blue[i]);
    }
}

/** Writes three values for each ray. */
void see(const Scene &scene, float radians_per_pixel, bool hologram, Block &block, float *red, float *green,
         float *blue) {
    shade(block, scene.surfaces(), radians_per_pixel, red, green, blue);
    if (hologram)
        addHologram(block, red, green, blue);
}

} // namespace

void renderColor(const Scene &scene, const RayTable &rays, const Pose &camera, bool hologram, uint8_t *rgb,
                 size_t stride_bytes, const Shot &shot) {
    Edges edges(rays);
    Block block;
    const size_t size = rays.x.size();
    std::vector<float> red(size), green(size), blue(size);
    std::vector<float> *const channels[] = {&red, &green, &blue};
    for (uint32_t v = 0; v < rays.height; v++) {
        for (uint32_t u = 0; u < rays.width; u += kBlock) {
            const size_t first = size_t(v) * rays.width + u;
            aim(block, &rays.x[first], &rays.y[first], &rays.z[first], int(std::min<uint32_t>(kBlock, rays.width - u)),
                camera);
            trace(block, scene.surfaces());
            edges.note(block, first);
            see(scene, rays.radians_per_pixel, hologram, block, &red[first], &green[first], &blue[first]);
        }
    }
    edges.forEachBlock(camera, [&](Block &finer, const std::vector<size_t> &pixels) {
        float values[3][kBlock];
        trace(finer, scene.surfaces());
        see(scene, rays.radians_per_pixel, hologram, finer, values[0], values[1], values[2]);
        for (int i = 0; i < 3; i++) {
            average(values[i], pixels.size());
            for (size_t n = 0; n < pixels.size(); n++)
                (*channels[i])[pixels[n]] = values[i][n];
        }
    });
    Noise noise = shot.noise;
    for (auto *channel : channels) {
        ml2sim::blur(*channel, rays, shot.turn);
        addNoise(channel->data(), int(size), noise, 0);
        noise.seed++;
    }
    for (uint32_t v = 0; v < rays.height; v++) {
        const size_t first = size_t(v) * rays.width;
        toBytes(&red[first], &green[first], &blue[first], rays.width, shot.gain, rgb + v * stride_bytes);
    }
}

} // namespace ml2sim
