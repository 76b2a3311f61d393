#include "trajectory.h"

#include <random>
#include <vector>

namespace ml2sim {
namespace {

constexpr double kTurn = 2 * 3.14159265358979323846;
constexpr double kShortestLoop_s = 2;

/** A value with its first and second derivative by time. */
struct Jet {
    double value = 0;
    double rate = 0;
    double acceleration = 0;
};

struct Sine {
    double amplitude;
    double radians_per_s;
    double phase;
};

Jet sum(const std::vector<Sine> &sines, double t) {
    Jet jet;
    for (const Sine &sine : sines) {
        const double s = sine.amplitude * std::sin(sine.radians_per_s * t + sine.phase);
        const double c = sine.amplitude * std::cos(sine.radians_per_s * t + sine.phase);
        jet.value += s;
        jet.rate += sine.radians_per_s * c;
        jet.acceleration -= sine.radians_per_s * sine.radians_per_s * s;
    }
    return jet;
}

/** Makes sines that repeat after a loop: as fast as asked for, and as wide or narrower. */
class Loop {
  public:
    Loop(uint64_t seed, double seconds) : random_(seed), seconds_(seconds) {}

    Sine sine(double amplitude, double hertz) {
        const double turns = std::ceil(hertz * seconds_);
        const double phase = kTurn * double(random_() >> 11) * 0x1p-53;
        return {amplitude * hertz * seconds_ / turns, kTurn * turns / seconds_, phase};
    }

  private:
    std::mt19937_64 random_;
    double seconds_;
};

/** The turns of a head: yaw to the left about y, then pitch up about x, then roll about z. */
struct Turning {
    Jet yaw, pitch, roll;

    Quaternion orientation() const {
        return Quaternion::about({0, 1, 0}, yaw.value) * Quaternion::about({1, 0, 0}, pitch.value) *
               Quaternion::about({0, 0, 1}, roll.value);
    }

    /** Sets both in head axes: the rates of yaw and pitch, carried through the turns that follow them. */
    void rates(Vec3 &velocity, Vec3 &acceleration) const {
        const Quaternion pitched = Quaternion::about({1, 0, 0}, -pitch.value);
        const Quaternion rolled = Quaternion::about({0, 0, 1}, -roll.value);
        const Vec3 pitching = {pitch.rate, 0, 0};
        const Vec3 rolling = {0, 0, roll.rate};
        const Vec3 yawed = rotate(pitched, {0, yaw.rate, 0});
        const Vec3 yawed_rate = rotate(pitched, {0, yaw.acceleration, 0}) - cross(pitching, yawed);
        const Vec3 both = rotate(rolled, yawed + pitching);
        const Vec3 both_rate = rotate(rolled, yawed_rate + Vec3{pitch.acceleration, 0, 0}) - cross(rolling, both);
        velocity = both + rolling;
        acceleration = both_rate + Vec3{0, 0, roll.acceleration};
    }
};

} // namespace

Trajectory Trajectory::looped(uint64_t seed, double loop_seconds) {
    if (!(loop_seconds >= kShortestLoop_s))
        throw std::invalid_argument("a loop takes 2 seconds or more");
    Loop loop(seed, loop_seconds);
    const std::vector<Sine> x = {loop.sine(0.40, 0.15), loop.sine(0.03, 0.7)};
    const std::vector<Sine> y = {loop.sine(0.06, 0.20), loop.sine(0.015, 1.8)};
    const std::vector<Sine> z = {loop.sine(0.40, 0.12), loop.sine(0.03, 0.8)};
    const std::vector<Sine> yaw = {loop.sine(0.40, 0.40), loop.sine(0.20, 1.0)};
    const std::vector<Sine> pitch = {loop.sine(0.10, 0.35), loop.sine(0.03, 1.1)};
    const std::vector<Sine> roll = {loop.sine(0.06, 0.30), loop.sine(0.02, 1.2)};
    const auto motion = [=](double t) {
        const Jet at_x = sum(x, t), at_y = sum(y, t), at_z = sum(z, t);
        const Turning turning = {sum(yaw, t), sum(pitch, t), sum(roll, t)};
        Motion now;
        now.head = {turning.orientation(), {at_x.value, at_y.value, at_z.value}};
        now.acceleration = {at_x.acceleration, at_y.acceleration, at_z.acceleration};
        turning.rates(now.angular_velocity, now.angular_acceleration);
        return now;
    };
    return {motion, loop_seconds};
}

} // namespace ml2sim
