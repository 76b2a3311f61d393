#include "blur.h"

#include "vectorized.h"

#include <algorithm>

namespace ml2sim {
namespace {

/** All pixels of a tile have the same way: a roll of 2 rad/s in 5 ms changes it by 0.16 from centre to edge. */
constexpr uint32_t kTile = 32;

/** A pixel that takes part in a mean. */
struct Tap {
    int across, down;
    float weight;
};

Vec3 rayAt(const RayTable &rays, size_t pixel) { return {rays.x[pixel], rays.y[pixel], rays.z[pixel]}; }

/** Returns how many pixels the image of what stands still moves at a pixel that has neighbours. */
Pixel way(const RayTable &rays, uint32_t u, uint32_t v, Vec3 turn) {
    const size_t pixel = size_t(v) * rays.width + u;
    const Vec3 across = 0.5 * (rayAt(rays, pixel + 1) - rayAt(rays, pixel - 1));
    const Vec3 down = 0.5 * (rayAt(rays, pixel + rays.width) - rayAt(rays, pixel - rays.width));
    const Vec3 moved = cross(rayAt(rays, pixel), turn);
    const double aa = dot(across, across), ad = dot(across, down), dd = dot(down, down);
    const double a = dot(across, moved), d = dot(down, moved), determinant = aa * dd - ad * ad;
    return {(dd * a - ad * d) / determinant, (aa * d - ad * a) / determinant};
}

void add(std::vector<Tap> &taps, int across, int down, double weight) {
    const auto found = std::find_if(taps.begin(), taps.end(),
                                    [&](const Tap &tap) { return tap.across == across && tap.down == down; });
    if (found != taps.end())
        found->weight += float(weight);
    else if (weight > 0)
        taps.push_back({across, down, float(weight)});
}

/** Returns the pixels along a way. Linear interpolation widens by a variance of 1/6, so the way is as much shorter. */
std::vector<Tap> tapsAlong(Pixel way) {
    const double length = std::hypot(way.u, way.v);
    const double kept = length * length > 2 ? std::sqrt(length * length - 2) / length : 0;
    const int count = 1 + 2 * int(kept * length);
    std::vector<Tap> taps;
    for (int n = 0; n < count; n++) {
        const double along = kept * ((n + 0.5) / count - 0.5), u = along * way.u, v = along * way.v;
        const int left = int(std::floor(u)), above = int(std::floor(v));
        const double right = u - left, below = v - above;
        add(taps, left, above, (1 - right) * (1 - below) / count);
        add(taps, left + 1, above, right * (1 - below) / count);
        add(taps, left, above + 1, (1 - right) * below / count);
        add(taps, left + 1, above + 1, right * below / count);
    }
    return taps;
}

ML2SIM_VECTORIZED
void accumulate(const float *from, float weight, uint32_t count, float *to) {
    for (uint32_t i = 0; i < count; i++)
        to[i] += weight * from[i];
}

/** Adds a tap's part to a run of pixels from column `u` on. Beside its border the picture goes on as there. */
void addTap(const float *row, int width, int u, const Tap &tap, int columns, float *to) {
    const int from = u + tap.across;
    const int first = std::clamp(-from, 0, columns), last = std::clamp(width - from, 0, columns);
    for (int i = 0; i < first; i++)
        to[i] += tap.weight * row[0];
    if (first < last)
        accumulate(row + from + first, tap.weight, uint32_t(last - first), to + first);
    for (int i = std::max(first, last); i < columns; i++)
        to[i] += tap.weight * row[width - 1];
}

} // namespace

void blur(std::vector<float> &values, const RayTable &rays, Vec3 turn) {
    if (length(turn) == 0)
        return;
    const auto width = int(rays.width), height = int(rays.height);
    std::vector<float> sharp(values.size());
    sharp.swap(values);
    for (int v = 0; v < height; v += kTile) {
        for (int u = 0; u < width; u += kTile) {
            const int columns = std::min<int>(kTile, width - u), rows = std::min<int>(kTile, height - v);
            const auto taps = tapsAlong(way(rays, uint32_t(std::clamp(u + columns / 2, 1, width - 2)),
                                            uint32_t(std::clamp(v + rows / 2, 1, height - 2)), turn));
            for (int row = v; row < v + rows; row++) {
                float *to = &values[size_t(row) * rays.width + size_t(u)];
                for (const auto &tap : taps)
                    addTap(&sharp[size_t(std::clamp(row + tap.down, 0, height - 1)) * rays.width], width, u, tap,
                           columns, to);
            }
        }
    }
}

} // namespace ml2sim
