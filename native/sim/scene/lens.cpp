#include "lens.h"

namespace ml2sim {
namespace {

constexpr double kFisheyeEdge_rad = 1.45;
constexpr double kPlumbBobEdge_rad = 1.2;
constexpr double kConverged = 1e-14;
/** Newton's method needs five at the most with the lenses of this headset. */
constexpr int kMostSteps = 50;

struct Point {
    double x;
    double y;
};

double polynomial(double q, double k1, double k2, double k3, double k4) {
    return 1 + q * (k1 + q * (k2 + q * (k3 + q * k4)));
}

/** Brown's radial and tangential terms, on the plane z = 1 with y down. */
struct Brown {
    double k1, k2, k3, p1, p2;

    Point bend(Point p) const {
        const double q = p.x * p.x + p.y * p.y;
        const double radial = polynomial(q, k1, k2, k3, 0);
        return {p.x * radial + 2 * p1 * p.x * p.y + p2 * (q + 2 * p.x * p.x),
                p.y * radial + p1 * (q + 2 * p.y * p.y) + 2 * p2 * p.x * p.y};
    }

    Point unbend(Point bent) const {
        Point p = bent;
        for (int step = 0; step < kMostSteps; step++) {
            const double q = p.x * p.x + p.y * p.y;
            const double radial = polynomial(q, k1, k2, k3, 0);
            const double slope = 2 * (k1 + q * (2 * k2 + q * 3 * k3)); // of radial, by q, twice
            const double xx = radial + slope * p.x * p.x + 2 * p1 * p.y + 6 * p2 * p.x;
            const double yy = radial + slope * p.y * p.y + 6 * p1 * p.y + 2 * p2 * p.x;
            const double xy = slope * p.x * p.y + 2 * p1 * p.x + 2 * p2 * p.y;
            const Point now = bend(p);
            const Point miss = {now.x - bent.x, now.y - bent.y};
            const double determinant = xx * yy - xy * xy;
            const Point change = {(yy * miss.x - xy * miss.y) / determinant, (xx * miss.y - xy * miss.x) / determinant};
            p = {p.x - change.x, p.y - change.y};
            if (std::hypot(change.x, change.y) < kConverged)
                break;
        }
        return p;
    }
};

Pixel toPixel(const Sensor &sensor, Point p) { return {sensor.fx * p.x + sensor.cx, sensor.fy * p.y + sensor.cy}; }

Point fromPixel(const Sensor &sensor, Pixel pixel) {
    return {(pixel.u - sensor.cx) / sensor.fx, (pixel.v - sensor.cy) / sensor.fy};
}

double angleFromAxis(Vec3 ray) { return std::atan2(std::hypot(ray.x, ray.y), -ray.z); }

/** The angle of incidence that the equidistant stage bends to `bent`. */
double unbendAngle(const double k[4], double bent) {
    double theta = bent;
    for (int step = 0; step < kMostSteps; step++) {
        const double q = theta * theta;
        const double miss = theta * polynomial(q, k[0], k[1], k[2], k[3]) - bent;
        const double change = miss / polynomial(q, 3 * k[0], 5 * k[1], 7 * k[2], 9 * k[3]);
        theta -= change;
        if (std::abs(change) < kConverged)
            break;
    }
    return theta;
}

} // namespace

std::optional<Pixel> FisheyeTangential::project(Vec3 ray) const {
    const double theta = angleFromAxis(ray);
    if (theta > kFisheyeEdge_rad)
        return std::nullopt;
    const double aside = std::hypot(ray.x, ray.y);
    const double scale = aside > 0 ? theta * polynomial(theta * theta, k[0], k[1], k[2], k[3]) / aside : 0;
    return toPixel(*this, Brown{0, 0, 0, p1, p2}.bend({ray.x * scale, -ray.y * scale}));
}

Vec3 FisheyeTangential::unproject(Pixel pixel) const {
    const Point radial = Brown{0, 0, 0, p1, p2}.unbend(fromPixel(*this, pixel));
    const double bent = std::hypot(radial.x, radial.y);
    if (bent == 0)
        return {0, 0, -1};
    const double theta = unbendAngle(k, bent);
    const double scale = std::sin(theta) / bent;
    return {radial.x * scale, -radial.y * scale, -std::cos(theta)};
}

std::optional<Pixel> PlumbBob::project(Vec3 ray) const {
    if (angleFromAxis(ray) > kPlumbBobEdge_rad)
        return std::nullopt;
    return toPixel(*this, Brown{k1, k2, k3, p1, p2}.bend({ray.x / -ray.z, -ray.y / -ray.z}));
}

Vec3 PlumbBob::unproject(Pixel pixel) const {
    const Point p = Brown{k1, k2, k3, p1, p2}.unbend(fromPixel(*this, pixel));
    return normalized({p.x, -p.y, -1});
}

} // namespace ml2sim
