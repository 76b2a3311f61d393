/** One surface while it is painted. Places are metres from its top left; colours go from 0 to 1. */
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace ml2sim {

struct Rgb {
    float r, g, b;
};

inline Rgb operator*(float s, Rgb c) { return {s * c.r, s * c.g, s * c.b}; }
inline Rgb between(Rgb a, Rgb b, float t) {
    return {a.r + t * (b.r - a.r), a.g + t * (b.g - a.g), a.b + t * (b.b - a.b)};
}

/** Metres from a surface's top left: x across, y down. */
struct Spot {
    float x, y;
};

struct Rectangle {
    float left, top, width, height;
};

/** Each returns how far a spot is outside of a shape, metres; negative is inside. */
inline float outside(const Rectangle &r, Spot s) {
    return std::max(std::max(r.left - s.x, s.x - r.left - r.width), std::max(r.top - s.y, s.y - r.top - r.height));
}

struct Disc {
    Spot center;
    float radius;
};

inline float outside(const Disc &disc, Spot s) {
    return std::hypot(s.x - disc.center.x, s.y - disc.center.y) - disc.radius;
}

/** A regular polygon: `turn` in radians. */
struct Polygon {
    Spot center;
    float radius;
    int sides;
    float turn;
};

inline float outside(const Polygon &polygon, Spot s) {
    const float step = 6.2831853f / float(polygon.sides);
    const float angle = std::atan2(s.y - polygon.center.y, s.x - polygon.center.x) - polygon.turn;
    const float fold = angle - step * std::round(angle / step);
    const float distance = std::hypot(s.x - polygon.center.x, s.y - polygon.center.y);
    return distance * std::cos(fold) - polygon.radius * std::cos(step / 2);
}

inline Rectangle boundsOf(const Rectangle &r) { return r; }
inline Rectangle boundsOf(const Disc &d) {
    return {d.center.x - d.radius, d.center.y - d.radius, 2 * d.radius, 2 * d.radius};
}
inline Rectangle boundsOf(const Polygon &p) { return boundsOf(Disc{p.center, p.radius}); }

class Canvas {
  public:
    Canvas(double width_m, double height_m, double texel_m, Rgb color);

    int width() const { return width_; }
    int height() const { return height_; }
    float texel() const { return texel_m_; }
    Rgb &at(int column, int row) { return texels_[size_t(row) * width_ + column]; }
    Spot centerOf(int column, int row) const { return {(column + 0.5f) * texel_m_, (row + 0.5f) * texel_m_}; }

    /** Paints over what is there; half a texel of the edge is blended. */
    template <class Shape> void paint(const Shape &shape, Rgb color) {
        forEach(boundsOf(shape), [&](Spot spot, Rgb &texel) {
            texel = between(texel, color, std::clamp(0.5f - outside(shape, spot) / texel_m_, 0.0f, 1.0f));
        });
    }

    /** Calls change(Spot, Rgb &) for each texel of a rectangle, and one more around it. */
    template <class Change> void forEach(const Rectangle &area, Change change) {
        const int left = std::max(0, int(area.left / texel_m_) - 1);
        const int top = std::max(0, int(area.top / texel_m_) - 1);
        const int right = std::min(width_, int((area.left + area.width) / texel_m_) + 2);
        const int bottom = std::min(height_, int((area.top + area.height) / texel_m_) + 2);
        for (int row = top; row < bottom; row++) {
            for (int column = left; column < right; column++)
                change(centerOf(column, row), at(column, row));
        }
    }

    /** Makes everything brighter and darker by value noise: spots of `cell_m`, up to `strength`. */
    void grain(uint64_t seed, float cell_m, float strength);

  private:
    int width_;
    int height_;
    float texel_m_;
    std::vector<Rgb> texels_;
};

} // namespace ml2sim
