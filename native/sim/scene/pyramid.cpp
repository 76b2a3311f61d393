#include "pyramid.h"

#include <algorithm>

namespace ml2sim {
namespace {

constexpr int kSmallest = 4; ///< Texels across the last level, at least.

Float3 narrow(Vec3 v) { return {float(v.x), float(v.y), float(v.z)}; }

uint32_t channel(float value) { return uint32_t(std::clamp(value * 255 + 0.5f, 0.0f, 255.0f)); }

uint32_t packed(Rgb c) {
    const float luma = 0.299f * c.r + 0.587f * c.g + 0.114f * c.b;
    return channel(c.r) | channel(c.g) << 8 | channel(c.b) << 16 | channel(luma) << 24;
}

Canvas halved(Canvas &fine) {
    const int width = (fine.width() + 1) / 2, height = (fine.height() + 1) / 2;
    Canvas coarse(width, height, 1, {});
    for (int row = 0; row < height; row++) {
        const int below = std::min(2 * row + 1, fine.height() - 1);
        for (int column = 0; column < width; column++) {
            const int right = std::min(2 * column + 1, fine.width() - 1);
            coarse.at(column, row) = between(between(fine.at(2 * column, 2 * row), fine.at(right, 2 * row), 0.5f),
                                             between(fine.at(2 * column, below), fine.at(right, below), 0.5f), 0.5f);
        }
    }
    return coarse;
}

void append(Canvas &canvas, std::vector<uint32_t> &texels) {
    for (int row = 0; row < canvas.height(); row++) {
        for (int column = 0; column < canvas.width(); column++)
            texels.push_back(packed(canvas.at(column, row)));
    }
}

} // namespace

Surface addPyramid(Canvas &canvas, const Plane &plane, std::vector<uint32_t> &texels) {
    Surface surface = {};
    surface.origin = narrow(plane.origin);
    surface.across = narrow(plane.across);
    surface.down = narrow(plane.down);
    surface.normal = narrow(plane.normal);
    surface.texels_per_m = 1 / canvas.texel();
    surface.width = canvas.width();
    surface.height = canvas.height();
    Canvas level = std::move(canvas);
    for (;;) {
        surface.offset[surface.last_level] = int(texels.size());
        append(level, texels);
        if (std::min(level.width(), level.height()) < 2 * kSmallest || surface.last_level + 1 == kMostLevels)
            break;
        level = halved(level);
        surface.last_level++;
    }
    return surface;
}

} // namespace ml2sim
