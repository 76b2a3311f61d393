// Exposure, noise and blur of the cameras, which follow light and motion: functions of time without state.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "head_path.h"
#include "scene/render.h"

namespace ml2sim {

/** Returns the ambient light in lux. With noise it repeats with the path of the head, as frames do. */
double lightAt(const HeadPath &path, int64_t mltime);

struct Exposure {
    int64_t nanos;
    float gain;       ///< 1 or more.
    float brightness; ///< 1 for an image whose exposure fits the light.
};

/** Takes the frames of a camera along a path, with the keys as they were when this was made. */
class Photography {
  public:
    /** `longestNanos` is the exposure in moderate light; in less the gain is higher. */
    Photography(std::shared_ptr<const HeadPath> path, uint32_t rate_hz, int64_t longestNanos);

    /** Without noise all frames are exposed for the longest time, with gain 1. */
    Exposure exposure(size_t frame) const;

    /** Returns how the renderer takes a frame. `brightness` is that of a frame without noise. */
    Shot shot(size_t frame, Camera camera, float brightness, uint64_t noiseSeed) const;

    /** Returns the noise of a camera with gain 1, which shows the scene `brightness` times as bright as it is. */
    Noise noise(size_t frame, uint64_t noiseSeed, float gain = 1, float brightness = 1) const;

    /** Returns the values of the keys. */
    std::string inputs() const;

  private:
    std::shared_ptr<const HeadPath> path_;
    uint32_t rate_hz_;
    int64_t longestNanos_;
    float readNoise_;
    double factor_;
};

} // namespace ml2sim
