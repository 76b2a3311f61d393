#include "imperfections.h"

#include <cmath>
#include <initializer_list>
#include <utility>

#include "clock.h"
#include "scene/hash.h"
#include "settings.h"

namespace ml2sim {
namespace {

constexpr double kTau = 6.283185307179586;

/** Quantities of head tracking. Numbers below are those of inertial units. */
enum Quantity : uint64_t { kJitter = 1000, kTurnJitter = 1003, kDrift = 1006, kHeading = 1009 };

/** Returns a uniform number in (0, 1), equal for equal keys. */
double uniform(uint64_t key) { return (static_cast<double>(mix(key) >> 11) + 0.5) * 0x1p-53; }

double seconds(int64_t nanos) { return static_cast<double>(nanos) / kSecond; }

/**
 * Returns a smooth noise with mean 0 and standard deviation 1, of which values further apart than 134 ms are
 * independent. The poses of a filter are smooth, so a camera's pose and the head's of about that time agree.
 */
double smoothNoise(uint64_t source, int64_t nanos) {
    constexpr int kKnots_log2 = 26;
    const uint64_t key = mix(source);
    const auto knot = static_cast<uint64_t>(nanos) >> kKnots_log2;
    const double t = static_cast<double>(nanos & ((1 << kKnots_log2) - 1)) / (1 << kKnots_log2);
    const double later = t * t * t * (10 + t * (6 * t - 15)), earlier = 1 - later; // with two continuous derivatives
    return (earlier * gaussian(key + knot) + later * gaussian(key + knot + 1)) / std::hypot(earlier, later);
}

/** A sine and its derivatives by time. */
struct Swing {
    double angle, rate, acceleration;
};

/** Returns the angle of the compute pack about its hinge: steps of 2 per second, with a harmonic; assumed. */
Swing swingAt(int64_t mltime) {
    Swing sum = {};
    for (const auto &[amplitude, hertz] : {std::pair{0.025, 2.0}, std::pair{0.008, 4.0}}) {
        // Whole periods of both sines fit a second, in which a double holds the time exactly.
        const double phase = kTau * hertz * seconds(mltime % kSecond);
        const double peak = number(Key::Noise) * amplitude, speed = kTau * hertz;
        sum.angle += peak * std::sin(phase);
        sum.rate += peak * speed * std::cos(phase);
        sum.acceleration -= peak * speed * speed * std::sin(phase);
    }
    return sum;
}

bool isDrawn(Imu unit) { return unit != Imu::ComputePack && isOn(Key::Mounts); }

/** Returns the key of numbers that `mounts` draws for a unit. */
uint64_t drawKey(Imu unit) {
    return mix(mix(static_cast<uint64_t>(number(Key::Mounts))) + static_cast<uint64_t>(unit));
}

} // namespace

double gaussian(uint64_t key) {
    return std::sqrt(-2 * std::log(uniform(key))) * std::cos(kTau * uniform(mix(key) ^ 0x5bd1e995));
}

double symmetric(uint64_t key) { return 2 * uniform(key) - 1; }

uint64_t noiseSource(uint64_t quantity) { return mix(static_cast<uint64_t>(number(Key::Seed))) + quantity; }

// Lévy's construction of Brownian motion (P. Lévy 1948; Z. Ciesielski 1961): the middle of an interval is the mean of
// its ends and a normal number whose variance is a quarter of the interval.
double wiener(uint64_t source, int64_t nanos, int period_log2) {
    // About a second: the white noise hides what the walk does in less.
    constexpr int64_t kFinest = int64_t{1} << 30;
    const uint64_t key = mix(~source);
    int64_t width = int64_t{1} << period_log2, from = nanos - (nanos & (width - 1));
    const auto at = [&](int64_t knot) {
        return std::sqrt(seconds(width) / 2) * gaussian(key + static_cast<uint64_t>(knot));
    };
    double low = at(from), high = at(from + width);
    while (width > kFinest) {
        width /= 2;
        const double middle = (low + high) / 2 + at(from + width);
        const bool isLater = nanos >= from + width;
        (isLater ? low : high) = middle;
        from += isLater ? width : 0;
    }
    return low + (high - low) * static_cast<double>(nanos - from) / static_cast<double>(width);
}

// Figures are assumed. After 10 m at 0.5 m/s the drift is some 0.1 % of the way; the headset's map bounds it to 12 mm
// and 0.07 degrees (standard deviations).
Pose withTrackingErrors(const Pose &head, int64_t mltime) {
    const double noise = number(Key::Noise);
    if (noise == 0)
        return head;
    constexpr double kJitter_m = 0.5e-3, kJitter_rad = 0.05 * kTau / 360, kDrift_m = 2e-3, kDrift_rad = 2e-4;
    constexpr int kMapped_log2 = 36; // 69 s
    const auto jitter = [&](uint64_t quantity) { return smoothNoise(noiseSource(quantity), mltime); };
    const auto drift = [&](uint64_t quantity) { return wiener(noiseSource(quantity), mltime, kMapped_log2); };
    const Vec3 turn = noise * kJitter_rad * Vec3{jitter(kTurnJitter), jitter(kTurnJitter + 1), jitter(kTurnJitter + 2)};
    const auto heading = Quaternion::about({0, 1, 0}, noise * kDrift_rad * drift(kHeading));
    return {heading * head.rotation * Quaternion::about(normalized(turn), length(turn)),
            head.position + noise * kJitter_m * Vec3{jitter(kJitter), jitter(kJitter + 1), jitter(kJitter + 2)} +
                noise * kDrift_m * Vec3{drift(kDrift), drift(kDrift + 1), drift(kDrift + 2)}};
}

Pose mountInHead(Imu unit) {
    if (!isDrawn(unit))
        return mount(unit);
    constexpr double kFarthest_m = 0.1;
    const uint64_t key = drawKey(unit);
    const double q[] = {gaussian(key), gaussian(key + 1), gaussian(key + 2), gaussian(key + 3)};
    const double norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    return {{q[0] / norm, q[1] / norm, q[2] / norm, q[3] / norm},
            kFarthest_m * Vec3{symmetric(key + 4), symmetric(key + 5), symmetric(key + 6)}};
}

int64_t lateNanos(Imu unit) {
    constexpr double kLatest = 0.02 * kSecond;
    return isDrawn(unit) ? std::llround(kLatest * symmetric(drawKey(unit) + 7)) : 0;
}

UnitInHead unitInHead(Imu unit, int64_t mltime) {
    const Pose place = mountInHead(unit);
    if (unit != Imu::ComputePack || !isOn(Key::Noise))
        return {place};
    constexpr Vec3 kHinge = {1, 0, 0}, kArm = {0, -0.1, 0};
    const auto swing = swingAt(mltime);
    const auto turn = Quaternion::about(kHinge, swing.angle);
    const Vec3 arm = rotate(turn, kArm), across = cross(kHinge, arm);
    return {{turn * place.rotation, place.position - kArm + arm},
            swing.rate * across,
            swing.acceleration * across + swing.rate * swing.rate * cross(kHinge, across),
            swing.rate * kHinge};
}

} // namespace ml2sim
