#include "exposure.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "clock.h"
#include "settings.h"

namespace ml2sim {
namespace {

constexpr double kTau = 6.283185307179586;
constexpr double kModerate_lux = 300;
constexpr double kShortestNanos = 100000;
constexpr double kMostGain = 16;
/** The time constant of automatic exposure, assumed. */
constexpr double kLag_s = 0.3;
/** Grey levels for an electron at gain 1: 255 of them are 10,000 electrons, assumed. */
constexpr double kLevelsPerElectron = 255.0 / 10000;

struct Flicker {
    double lux, hertz;
};
constexpr Flicker kFlickers[] = {{120, 0.1}, {30, 0.77}};

/** Returns the light as a sensor measures it that follows with a time constant, once it has settled. */
double lightBehind(double lag_s, double seconds, double period_s) {
    double lux = kModerate_lux;
    for (const auto &flicker : kFlickers) {
        const double hertz = period_s > 0 ? std::ceil(flicker.hertz * period_s) / period_s : flicker.hertz;
        const double turn = kTau * hertz, late = turn * lag_s;
        lux += flicker.lux / std::hypot(1, late) * std::sin(turn * seconds - std::atan(late));
    }
    return lux;
}

} // namespace

double lightAt(const HeadPath &path, int64_t mltime) {
    if (!isOn(Key::Noise))
        return lightBehind(0, static_cast<double>(mltime) / kSecond, 0);
    return lightBehind(0, path.secondsAt(mltime), path.periodSeconds());
}

Photography::Photography(std::shared_ptr<const HeadPath> path, uint32_t rate_hz, int64_t longestNanos)
    : path_(std::move(path)), rate_hz_(rate_hz), longestNanos_(longestNanos),
      readNoise_(static_cast<float>(number(Key::ImageNoise))), factor_(number(Key::Noise)) {}

Exposure Photography::exposure(size_t frame) const {
    if (factor_ == 0)
        return {longestNanos_, 1, 1};
    const double seconds = static_cast<double>(captureTime(static_cast<int64_t>(frame), rate_hz_)) / kSecond;
    const double light = lightBehind(0, seconds, path_->periodSeconds());
    const double measured = lightBehind(kLag_s, seconds, path_->periodSeconds());
    const auto longest = static_cast<double>(longestNanos_);
    const double wanted = longest * kModerate_lux / measured;
    const double nanos = std::clamp(wanted, kShortestNanos, longest);
    const double gain = std::clamp(wanted / nanos, 1.0, kMostGain);
    return {std::llround(nanos), static_cast<float>(gain),
            static_cast<float>(light / kModerate_lux * nanos / longest * gain)};
}

Shot Photography::shot(size_t frame, Camera camera, float brightness, uint64_t noiseSeed) const {
    const auto exposed = exposure(frame);
    const float shown = brightness * exposed.brightness;
    Shot shot = {shown, noise(frame, noiseSeed, exposed.gain, shown)};
    if (factor_ != 0)
        shot.turn = static_cast<double>(exposed.nanos) / kSecond *
                    rotate(mount(camera).rotation.conjugate(), path_->atFrame(frame, rate_hz_).angular_velocity);
    return shot;
}

// EMVA 1288: the variance of a pixel is (gain * read noise)^2 + gain * levels per electron * value. The renderer adds
// noise before it multiplies by the brightness.
Noise Photography::noise(size_t frame, uint64_t noiseSeed, float gain, float brightness) const {
    if (factor_ == 0)
        return {readNoise_, noiseSeed, frame};
    const auto levels = static_cast<float>(factor_ * factor_ * kLevelsPerElectron);
    return {readNoise_ * gain / brightness, noiseSeed, frame, 0, levels * gain / brightness};
}

std::string Photography::inputs() const {
    return "noise=" + std::to_string(readNoise_) + (factor_ == 0 ? "" : " exposed=" + std::to_string(factor_));
}

} // namespace ml2sim
