// What a running stream shows: the films of the simulated headset, on its grid of capture times.
#pragma once

#include <cstddef>
#include <memory>

#include "sensor_models.h"

namespace ml2sim::xr {

/** One plane of a capture, tightly packed. */
struct Plane {
    const uint8_t *data;
    uint32_t width;
    uint32_t height;
    uint32_t bytesPerPixel; ///< 0 for JPEG, which is bytes long and has no rows.
    uint32_t bytes;
};

class Pictures {
  public:
    /** Draws what the mode shows, which may take seconds. */
    static std::shared_ptr<Pictures> of(const SensorModel &sensor, uint32_t stream, const Mode &mode);

    virtual ~Pictures() = default;

    /** The picture, or its confidence or flags, of capture number index. Read only, valid until the process ends. */
    virtual Plane plane(XrPixelSensorFrameTypeML type, int64_t index) = 0;
    /** No plane of the type is larger. */
    virtual uint32_t mostBytes(XrPixelSensorFrameTypeML type) const = 0;

    int64_t captureTimeOf(int64_t index) const;
    /** MLTime at which the capture can be got. */
    int64_t deliveryTimeOf(int64_t index) const;
    /** The newest capture that can be got at an MLTime. */
    int64_t newestAt(int64_t mltime) const;
    int64_t exposureNanos() const { return exposureNanos_; }

  protected:
    Pictures(uint32_t rate_hz, int64_t delayNanos, int64_t exposureNanos)
        : rate_hz_(rate_hz), delayNanos_(delayNanos), exposureNanos_(exposureNanos) {}
    size_t filmIndex(int64_t index) const;

    const uint32_t rate_hz_;
    const int64_t delayNanos_;
    const int64_t exposureNanos_;
};

/** By shape of the lens; nothing for eye cameras, which tell none. */
void writeIntrinsics(XrPixelSensorFisheyeIntrinsicsML *out);
void writeIntrinsics(const SensorModel &sensor, const Mode &mode, XrPixelSensorPinholeIntrinsicsML *out);

} // namespace ml2sim::xr
