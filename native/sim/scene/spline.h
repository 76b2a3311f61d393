/** Natural cubic splines through values of several components. */
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

namespace ml2sim {

/** Passes through every knot; first and second derivative are continuous, the second is zero at both ends. */
template <size_t N> class Spline {
  public:
    using Value = std::array<double, N>;

    struct Knot {
        double at;
        Value value;
    };

    struct Sample {
        Value value, rate, acceleration;
    };

    /** At least two, `at` rising. */
    explicit Spline(std::vector<Knot> knots) : knots_(std::move(knots)), bends_(knots_.size(), Value{}) {
        for (size_t n = 0; n < N; n++)
            solve(n);
    }

    /** `t` from the first knot's `at` to the last's. */
    Sample at(double t) const {
        const auto after = std::upper_bound(knots_.begin() + 1, knots_.end() - 1, t,
                                            [](double time, const Knot &knot) { return time < knot.at; });
        const size_t i = size_t(after - knots_.begin()) - 1;
        const double h = knots_[i + 1].at - knots_[i].at;
        const double b = (t - knots_[i].at) / h;
        const double a = 1 - b;
        Sample sample;
        for (size_t n = 0; n < N; n++) {
            const double from = knots_[i].value[n], to = knots_[i + 1].value[n];
            const double bend_from = bends_[i][n], bend_to = bends_[i + 1][n];
            sample.value[n] = a * from + b * to + ((a * a * a - a) * bend_from + (b * b * b - b) * bend_to) * h * h / 6;
            sample.rate[n] = (to - from) / h + ((3 * b * b - 1) * bend_to - (3 * a * a - 1) * bend_from) * h / 6;
            sample.acceleration[n] = a * bend_from + b * bend_to;
        }
        return sample;
    }

  private:
    /** The second derivatives of component n: a tridiagonal system, eliminated forwards, then substituted back. */
    void solve(size_t n) {
        std::vector<double> upper(knots_.size(), 0);
        for (size_t i = 1; i + 1 < knots_.size(); i++) {
            const double before = knots_[i].at - knots_[i - 1].at;
            const double after = knots_[i + 1].at - knots_[i].at;
            const double slopes = (knots_[i + 1].value[n] - knots_[i].value[n]) / after -
                                  (knots_[i].value[n] - knots_[i - 1].value[n]) / before;
            const double pivot = 2 * (before + after) - before * upper[i - 1];
            upper[i] = after / pivot;
            bends_[i][n] = (6 * slopes - before * bends_[i - 1][n]) / pivot;
        }
        for (size_t i = knots_.size() - 1; i-- > 1;)
            bends_[i][n] -= upper[i] * bends_[i + 1][n];
    }

    std::vector<Knot> knots_;
    std::vector<Value> bends_; ///< Second derivatives at the knots.
};

} // namespace ml2sim
