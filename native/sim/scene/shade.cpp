#include "trace.h"
#include "vectorized.h"

#include <algorithm>
#include <cstring>

namespace ml2sim {
namespace {

/** Widths of a pixel: what lens and pixel blur together. In sharper pictures corners cannot be found without bias. */
constexpr float kBlur = 1.4f;

/** Four texels about a spot, and how near it is to each. */
struct Texels {
    int index; ///< The top left one.
    int stride;
    float right; ///< 0 to 1
    float down;
};

/** The texels of a surface that rays meet: linear in the ray's direction times its distance. */
struct Footing {
    float from_across, from_down;
    Float3 across, down;
    Float3 normal;
    float width, height;
    float texels_per_radian_m;
};

float dot(Float3 a, Float3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
Float3 times(float s, Float3 a) { return {s * a.x, s * a.y, s * a.z}; }

Footing footing(const Surface &surface, Float3 origin, float radians_per_pixel) {
    const Float3 from = {origin.x - surface.origin.x, origin.y - surface.origin.y, origin.z - surface.origin.z};
    const float scale = surface.texels_per_m;
    return {scale * dot(from, surface.across),
            scale * dot(from, surface.down),
            times(scale, surface.across),
            times(scale, surface.down),
            surface.normal,
            float(surface.width),
            float(surface.height),
            scale * radians_per_pixel * kBlur};
}

/** Clamped so that the right and lower neighbours exist, or have no weight. */
inline Texels texelsAt(float across, float down, int level, const Surface &surface) {
    const uint32_t bits = uint32_t(127 - level) << 23;
    float scale;
    std::memcpy(&scale, &bits, sizeof scale);
    const int round_up = (1 << level) - 1;
    const int width = (surface.width + round_up) >> level, height = (surface.height + round_up) >> level;
    const float x = std::min(std::max(across * scale - 0.5f, 0.0f), float(width - 1));
    const float y = std::min(std::max(down * scale - 0.5f, 0.0f), float(height - 1));
    const int column = int(x), row = int(y);
    return {surface.offset[level] + row * width + column, width, x - float(column), y - float(row)};
}

inline float channel(uint32_t texel, int shift) { return float(int32_t(texel >> shift & 255)); }

inline float bilinear(const uint32_t *texture, const Texels &at, int shift) {
    const float a = channel(texture[at.index], shift), b = channel(texture[at.index + 1], shift);
    const float c = channel(texture[at.index + at.stride], shift),
                d = channel(texture[at.index + at.stride + 1], shift);
    const float above = a + at.right * (b - a), below = c + at.right * (d - c);
    return above + at.down * (below - above);
}

/** Calls put(i, fine, coarse, weight of coarse) for the rays from `begin` to `end`, which all meet `surface`. */
template <class Put>
inline __attribute__((always_inline)) void sample(const Block &block, const Surface &surface, const Footing &f,
                                                  int begin, int end, Put put) {
    for (int i = begin; i < end; i++) {
        const float t = block.distance[i];
        const float x = t * block.x[i], y = t * block.y[i], z = t * block.z[i];
        const float across = f.from_across + x * f.across.x + y * f.across.y + z * f.across.z;
        const float down = f.from_down + x * f.down.x + y * f.down.y + z * f.down.z;
        const float facing = -(block.x[i] * f.normal.x + block.y[i] * f.normal.y + block.z[i] * f.normal.z);
        const float texels = std::max(t * f.texels_per_radian_m / facing, 1.0f);
        uint32_t bits;
        std::memcpy(&bits, &texels, sizeof bits);
        const int level = std::min(int(bits >> 23) - 127, surface.last_level - 1);
        const uint32_t fraction_bits = (bits & 0x7fffff) | 127u << 23;
        float weight;
        std::memcpy(&weight, &fraction_bits, sizeof weight);
        put(i, texelsAt(across, down, level, surface), texelsAt(across, down, level + 1, surface), weight - 1);
    }
}

template <class Sample> void forEachSurface(const Block &block, Sample sample) {
    for (int begin = 0; begin < block.count;) {
        int end = begin + 1;
        while (end < block.count && block.surface[end] == block.surface[begin])
            end++;
        sample(block.surface[begin], begin, end);
        begin = end;
    }
}

ML2SIM_VECTORIZED
void shadeSpan(const Block &block, const Surface &surface, const Footing &footing, const uint32_t *texture, int begin,
               int end, float *luma) {
    sample(block, surface, footing, begin, end, [&](int i, const Texels &fine, const Texels &coarse, float weight) {
        const float sharp = bilinear(texture, fine, 24);
        luma[i] = sharp + weight * (bilinear(texture, coarse, 24) - sharp);
    });
}

ML2SIM_VECTORIZED
void shadeSpan(const Block &block, const Surface &surface, const Footing &footing, const uint32_t *texture, int begin,
               int end, float *red, float *green, float *blue) {
    sample(block, surface, footing, begin, end, [&](int i, const Texels &fine, const Texels &coarse, float weight) {
        float *const channels[] = {red, green, blue};
        for (int n = 0; n < 3; n++) {
            const float sharp = bilinear(texture, fine, 8 * n);
            channels[n][i] = sharp + weight * (bilinear(texture, coarse, 8 * n) - sharp);
        }
    });
}

} // namespace

void shade(const Block &block, const Surfaces &surfaces, float radians_per_pixel, float *luma) {
    forEachSurface(block, [&](int index, int begin, int end) {
        const Surface &surface = surfaces.all[index];
        shadeSpan(block, surface, footing(surface, block.origin, radians_per_pixel), surfaces.texels.data(), begin, end,
                  luma);
    });
}

void shade(const Block &block, const Surfaces &surfaces, float radians_per_pixel, float *red, float *green,
           float *blue) {
    forEachSurface(block, [&](int index, int begin, int end) {
        const Surface &surface = surfaces.all[index];
        shadeSpan(block, surface, footing(surface, block.origin, radians_per_pixel), surfaces.texels.data(), begin, end,
                  red, green, blue);
    });
}

} // namespace ml2sim
