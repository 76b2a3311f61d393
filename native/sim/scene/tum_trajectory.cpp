#include "scene.h"
#include "spline.h"
#include "trajectory.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <sstream>

namespace ml2sim {
namespace {

/** x y z of the position, then x y z w of the rotation. */
using HeadSpline = Spline<7>;

/** A vector of the world x forward, y left, z up in x right, y up, z backward. */
Vec3 fromRos(double x, double y, double z) { return {-y, z, -x}; }

bool isInside(Vec3 p) {
    const Vec3 low = p - kRoomLow, high = kRoomHigh - p;
    return low.x > 0 && low.y > 0 && low.z > 0 && high.x > 0 && high.y > 0 && high.z > 0;
}

class TumReader {
  public:
    explicit TumReader(const std::string &path) : path_(path), file_(path) {
        if (!file_)
            throw TrajectoryError(path + ": cannot be read");
    }

    std::vector<HeadSpline::Knot> read() {
        std::vector<HeadSpline::Knot> knots;
        for (std::string line; std::getline(file_, line);) {
            line_number_++;
            const size_t text = line.find_first_not_of(" \t\r");
            if (text == std::string::npos || line[text] == '#')
                continue;
            knots.push_back(knot(line, knots));
        }
        if (knots.size() < 2)
            fail("the file ends; expected 2 poses or more, found " + std::to_string(knots.size()));
        return knots;
    }

  private:
    HeadSpline::Knot knot(const std::string &line, const std::vector<HeadSpline::Knot> &before) {
        std::istringstream words(line);
        std::array<double, 8> n;
        for (double &number : n) {
            if (!(words >> number))
                fail("expected 8 numbers, found \"" + line + "\"");
        }
        std::string rest;
        if (words >> rest)
            fail("expected 8 numbers, found \"" + line + "\"");
        if (!before.empty() && n[0] <= start_s_ + before.back().at)
            fail("expected a later time than the line before");
        if (before.empty())
            start_s_ = n[0];

        const Vec3 position = fromRos(n[1], n[2], n[3]);
        if (!isInside(position))
            fail("the position is outside the simulated room");
        const double norm = std::sqrt(n[4] * n[4] + n[5] * n[5] + n[6] * n[6] + n[7] * n[7]);
        if (!(std::abs(norm - 1) < 0.01))
            fail("expected a unit quaternion, found length " + std::to_string(norm));
        const Vec3 axis = fromRos(n[4], n[5], n[6]);
        HeadSpline::Value value = {position.x, position.y, position.z, axis.x, axis.y, axis.z, n[7]};
        // q and -q are the same rotation; the spline must take the near one.
        if (!before.empty() && alignment(value, before.back().value) < 0) {
            for (size_t i = 3; i < 7; i++)
                value[i] = -value[i];
        }
        return {n[0] - start_s_, value};
    }

    static double alignment(const HeadSpline::Value &a, const HeadSpline::Value &b) {
        return a[3] * b[3] + a[4] * b[4] + a[5] * b[5] + a[6] * b[6];
    }

    [[noreturn]] void fail(const std::string &why) const {
        throw TrajectoryError(path_ + ":" + std::to_string(line_number_) + ": " + why);
    }

    std::string path_;
    std::ifstream file_;
    int line_number_ = 0;
    double start_s_ = 0;
};

Quaternion quaternionOf(const HeadSpline::Value &v) { return {v[3], v[4], v[5], v[6]}; }
Vec3 positionOf(const HeadSpline::Value &v) { return {v[0], v[1], v[2]}; }

/**
 * The rotation is s / |s|, s the spline through the quaternions. With s' and s'' its derivatives, the angular velocity
 * is 2 vec(conj(s) s') / |s|^2, and its derivative follows by the product rule (conj(s') s' has no vector part).
 */
Motion motionOf(const HeadSpline::Sample &sample) {
    const Quaternion s = quaternionOf(sample.value), rate = quaternionOf(sample.rate);
    const double square = dot(s.vector(), s.vector()) + s.w * s.w;
    const double square_rate = 2 * (dot(s.vector(), rate.vector()) + s.w * rate.w);
    const double scale = 1 / std::sqrt(square);
    Motion motion;
    motion.head = {{scale * s.x, scale * s.y, scale * s.z, scale * s.w}, positionOf(sample.value)};
    motion.acceleration = positionOf(sample.acceleration);
    motion.angular_velocity = (2 / square) * (s.conjugate() * rate).vector();
    const Vec3 turning = (2 / square) * (s.conjugate() * quaternionOf(sample.acceleration)).vector();
    motion.angular_acceleration = turning - (square_rate / square) * motion.angular_velocity;
    return motion;
}

} // namespace

Trajectory Trajectory::fromTum(const std::string &path) {
    const std::vector<HeadSpline::Knot> knots = TumReader(path).read();
    const double duration_s = knots.back().at;
    const auto motion = [spline = HeadSpline(knots), duration_s](double t) {
        const bool isMoving = t >= 0 && t <= duration_s;
        const Motion now = motionOf(spline.at(std::clamp(t, 0.0, duration_s)));
        return isMoving ? now : Motion{now.head, {}, {}, {}};
    };
    return {motion, duration_s};
}

} // namespace ml2sim
