#include "edges.h"

namespace ml2sim {
namespace {

/** Writes the rays a quarter of a pixel to all four sides; the table's neighbours say how far that is. */
void spread(const std::vector<float> &component, size_t pixel, size_t row, float *out) {
    const float center = component[pixel];
    const float across = (component[pixel + 1] - component[pixel - 1]) / 8;
    const float down = (component[pixel + row] - component[pixel - row]) / 8;
    out[0] = center - across - down;
    out[1] = center + across - down;
    out[2] = center - across + down;
    out[3] = center + across + down;
}

} // namespace

void Edges::note(const Block &block, size_t first) {
    for (int i = 0; i < block.count; i++)
        surface_[first + i] = uint8_t(block.surface[i]);
}

void Edges::aimFiner(Block &block, const Pose &camera, const std::vector<size_t> &pixels) const {
    float x[kBlock], y[kBlock], z[kBlock];
    for (size_t n = 0; n < pixels.size(); n++) {
        spread(rays_.x, pixels[n], rays_.width, &x[kRaysPerPixel * n]);
        spread(rays_.y, pixels[n], rays_.width, &y[kRaysPerPixel * n]);
        spread(rays_.z, pixels[n], rays_.width, &z[kRaysPerPixel * n]);
    }
    aim(block, x, y, z, kRaysPerPixel * int(pixels.size()), camera);
}

void average(float *values, size_t pixels) {
    for (size_t n = 0; n < pixels; n++) {
        const float *four = &values[Edges::kRaysPerPixel * n];
        values[n] = (four[0] + four[1] + four[2] + four[3]) / Edges::kRaysPerPixel;
    }
}

} // namespace ml2sim
