#include "canvas.h"

#include <algorithm>

#include "hash.h"

namespace ml2sim {
namespace {

float smooth(float t) { return t * t * (3 - 2 * t); }

} // namespace

Canvas::Canvas(double width_m, double height_m, double texel_m, Rgb color)
    : width_(int(std::lround(width_m / texel_m))), height_(int(std::lround(height_m / texel_m))),
      texel_m_(float(texel_m)), texels_(size_t(width_) * height_, color) {}

void Canvas::grain(uint64_t seed, float cell_m, float strength) {
    const int cell = std::max(1, int(cell_m / texel_m_));
    const int columns = width_ / cell + 2;
    std::vector<float> weights(cell);
    for (int n = 0; n < cell; n++)
        weights[n] = smooth((n + 0.5f) / cell);
    Random random(mix(seed));
    std::vector<float> lattice(size_t(columns) * (height_ / cell + 2));
    for (float &knot : lattice)
        knot = random.uniform(-strength, strength);
    std::vector<float> knots(columns);
    for (int row = 0; row < height_; row++) {
        const float *above = &lattice[size_t(row / cell) * columns];
        const float down = weights[row % cell];
        for (int n = 0; n < columns; n++)
            knots[n] = 1 + above[n] + down * (above[n + columns] - above[n]);
        for (int column = 0; column < width_; column++) {
            const float *left = &knots[column / cell];
            Rgb &texel = at(column, row);
            texel = (left[0] + weights[column % cell] * (left[1] - left[0])) * texel;
        }
    }
}

} // namespace ml2sim
