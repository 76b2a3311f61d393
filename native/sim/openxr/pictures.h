// The images of a running stream, by capture time.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "../drawer.h"
#include "../exposure.h"
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
    /** Returns the images of a mode; renders one, for which the scene must be built. */
    static std::shared_ptr<Pictures> of(const SensorModel &sensor, uint32_t stream, const Mode &mode);

    virtual ~Pictures() = default;

    /**
     * Returns the newest capture from number `first` on, and after MLTime `last`, that is delivered at `now` and drawn.
     * Begins to draw one that is to come. Captures that are not drawn when they fall due are left out.
     */
    std::optional<int64_t> newestDrawn(int64_t first, int64_t last, int64_t now);

    /** Returns the image, confidence or flags of capture number index, which is drawn, read-only and valid until the
     * process ends. */
    virtual Plane plane(XrPixelSensorFrameTypeML type, int64_t index) = 0;
    /** Returns the size of the largest plane of the type. */
    virtual uint32_t mostBytes(XrPixelSensorFrameTypeML type) const = 0;

    int64_t captureTimeOf(int64_t index) const;
    /** Returns the MLTime at which the capture is delivered. */
    int64_t deliveryTimeOf(int64_t index) const;
    /** Returns the newest capture that is delivered at an MLTime. */
    int64_t newestAt(int64_t mltime) const;
    /** Returns how capture number `index` was exposed. */
    Exposure exposure(int64_t index) const;

  protected:
    Pictures(const RenderPlan &plan, uint32_t rate_hz, int64_t delayNanos, int64_t exposureNanos, bool followsLight);
    const uint8_t *frame(int64_t index);

  private:
    std::vector<FrameCache::Place> framesOf(int64_t index) const;

    const std::shared_ptr<FrameCache> cache_;
    const uint32_t rate_hz_;
    const int64_t delayNanos_;
    const int64_t exposureNanos_;
    const bool followsLight_;
    Drawer drawer_;
    int64_t last_ = -1; ///< The last capture that newestDrawn returned.
};

/** Write the intrinsics of the lens. The eye cameras have none. */
void writeIntrinsics(XrPixelSensorFisheyeIntrinsicsML *out);
void writeIntrinsics(const SensorModel &sensor, const Mode &mode, XrPixelSensorPinholeIntrinsicsML *out);

} // namespace ml2sim::xr
