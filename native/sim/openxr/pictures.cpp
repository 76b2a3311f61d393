#include "pictures.h"

#include <algorithm>
#include <cstring>
#include <vector>

#include "../clock.h"
#include "../counters.h"
#include "../depth_modes.h"
#include "../head_path.h"
#include "../ml2sim.h"
#include "../render_plans.h"
#include "../settings.h"
#include "scene/cameras.h"

namespace ml2sim::xr {
namespace {

class GreyPictures : public Pictures {
  public:
    GreyPictures(const RenderPlan &plan, const Mode &mode, int64_t exposureNanos, bool followsLight)
        : Pictures(plan, mode.rate_hz, 9000000, exposureNanos, followsLight),
          width_(static_cast<uint32_t>(mode.size.width)), height_(static_cast<uint32_t>(mode.size.height)) {}

    Plane plane(XrPixelSensorFrameTypeML, int64_t index) override {
        return {frame(index), width_, height_, 1, width_ * height_};
    }
    uint32_t mostBytes(XrPixelSensorFrameTypeML) const override { return width_ * height_; }

  private:
    uint32_t width_, height_;
};

/** Converts flags of the vendor's C interface to those of OpenXR. */
uint32_t translate(uint32_t flags) {
    constexpr uint32_t kLow = 0x3f, kHigh = 0x700;
    return flags == 0 ? XR_PIXEL_SENSOR_DEPTH_VALID_ML : (flags & kLow) << 1 | (flags & kHigh) >> 1;
}

class DepthPictures : public Pictures {
  public:
    DepthPictures(uint32_t stream, const Mode &mode)
        : Pictures(depthRenderPlan(choice(stream, mode)), choice(stream, mode).delivered_hz, 7000000,
                   stream == 0 ? 1600000 : 375000, false),
          pixels_(mode.size.width * mode.size.height), width_(static_cast<uint32_t>(mode.size.width)),
          height_(static_cast<uint32_t>(mode.size.height)) {}

    Plane plane(XrPixelSensorFrameTypeML type, int64_t index) override {
        const uint8_t *planes = frame(index);
        const uint8_t *data = type == XR_PIXEL_SENSOR_DEPTH_CONFIDENCE_ML ? planes + bytes()
                              : type == XR_PIXEL_SENSOR_DEPTH_FLAGS_ML    ? translated(planes + 2 * bytes())
                                                                          : planes;
        return {data, width_, height_, 4, bytes()};
    }
    uint32_t mostBytes(XrPixelSensorFrameTypeML) const override { return bytes(); }

  private:
    static DepthChoice choice(uint32_t stream, const Mode &mode) {
        const auto type = stream == 0 ? MLDepthCameraFrameType_LongRange : MLDepthCameraFrameType_ShortRange;
        const uint32_t planes =
            mode.format == XR_PIXEL_SENSOR_DEPTH_RAW_ML
                ? MLDepthCameraFlags_RawDepthImage
                : MLDepthCameraFlags_DepthImage | MLDepthCameraFlags_Confidence | MLDepthCameraFlags_DepthFlags;
        return {type, planes, std::min(mode.rate_hz, mode.rate_hz == 60 ? 30u : mode.rate_hz)};
    }

    uint32_t bytes() const { return static_cast<uint32_t>(pixels_.size() * 4); }

    const uint8_t *translated(const uint8_t *flags) {
        std::transform(reinterpret_cast<const uint32_t *>(flags), reinterpret_cast<const uint32_t *>(flags + bytes()),
                       pixels_.begin(), translate);
        return reinterpret_cast<const uint8_t *>(pixels_.data());
    }

    std::vector<uint32_t> pixels_;
    uint32_t width_, height_;
};

class ColorPictures : public Pictures {
  public:
    ColorPictures(const Mode &mode, bool isMixed)
        : Pictures(colorRenderPlan(request(mode, isMixed)), mode.rate_hz, 15000000, kColorExposureNanos, true),
          width_(static_cast<uint32_t>(mode.size.width)), height_(static_cast<uint32_t>(mode.size.height)) {}

    Plane plane(XrPixelSensorFrameTypeML, int64_t index) override {
        const uint8_t *jpeg = frame(index);
        uint32_t bytes;
        std::memcpy(&bytes, jpeg, sizeof bytes);
        return {jpeg + sizeof bytes, width_, height_, 0, bytes};
    }
    uint32_t mostBytes(XrPixelSensorFrameTypeML) const override { return width_ * height_ * 3 / 2; }

  private:
    static ml2sim_color_request request(const Mode &mode, bool isMixed) {
        return {static_cast<uint32_t>(mode.size.width), static_cast<uint32_t>(mode.size.height), mode.rate_hz, isMixed};
    }

    uint32_t width_, height_;
};

RenderPlan greyFilm(CameraId camera, uint32_t stream) {
    const auto exposure = stream == 0 ? MLWorldCameraFrameType_NormalExposure : MLWorldCameraFrameType_LowExposure;
    switch (camera) {
    case CameraId::WorldLeft:
        return worldRenderPlan(MLWorldCameraIdentifier_Left, exposure);
    case CameraId::WorldCenter:
        return worldRenderPlan(MLWorldCameraIdentifier_Center, exposure);
    case CameraId::WorldRight:
        return worldRenderPlan(MLWorldCameraIdentifier_Right, exposure);
    case CameraId::TempleLeft:
        return eyeRenderPlan(EyeCamera::LeftTemple);
    case CameraId::NasalLeft:
        return eyeRenderPlan(EyeCamera::LeftNasal);
    case CameraId::NasalRight:
        return eyeRenderPlan(EyeCamera::RightNasal);
    default:
        return eyeRenderPlan(EyeCamera::RightTemple);
    }
}

template <class Lens, class Intrinsics> void writeShape(const Lens &lens, Intrinsics *out) {
    const auto f = [](double value) { return static_cast<float>(value); };
    out->focalLength = {f(lens.fx), f(lens.fy)};
    out->principalPoint = {f(lens.cx), f(lens.cy)};
    out->fov = {f(fovDegrees(lens)), f(fovDegrees(lens))};
}

} // namespace

std::shared_ptr<Pictures> Pictures::of(const SensorModel &sensor, uint32_t stream, const Mode &mode) {
    std::shared_ptr<Pictures> pictures;
    if (sensor.camera == CameraId::Depth)
        pictures = std::make_shared<DepthPictures>(stream, mode);
    else if (sensor.camera == CameraId::Color)
        pictures =
            std::make_shared<ColorPictures>(mode, stream == 1 && mode.reality == XR_PIXEL_SENSOR_REALITY_MIXED_ML);
    else
        pictures = std::make_shared<GreyPictures>(greyFilm(sensor.camera, stream), mode, kWorldExposureNanos[stream],
                                                  sensor.camera <= CameraId::WorldRight);
    HeadPath::current()->start();
    return pictures;
}

int64_t Pictures::captureTimeOf(int64_t index) const { return captureTime(index, rate_hz_); }

int64_t Pictures::deliveryTimeOf(int64_t index) const { return captureTimeOf(index) + delayNanos_; }

int64_t Pictures::newestAt(int64_t mltime) const { return captureIndex(mltime - delayNanos_, rate_hz_); }

Pictures::Pictures(const RenderPlan &plan, uint32_t rate_hz, int64_t delayNanos, int64_t exposureNanos,
                   bool followsLight)
    : cache_(FrameCache::of(plan)), rate_hz_(rate_hz), delayNanos_(delayNanos), exposureNanos_(exposureNanos),
      followsLight_(followsLight) {
    FrameCache::draw({{cache_.get(), 0}});
}

std::vector<FrameCache::Place> Pictures::framesOf(int64_t index) const {
    return {{cache_.get(), HeadPath::current()->frameIndex(index, rate_hz_)}};
}

const uint8_t *Pictures::frame(int64_t index) {
    return cache_->frame(HeadPath::current()->frameIndex(index, rate_hz_));
}

Exposure Pictures::exposure(int64_t index) const {
    if (!followsLight_)
        return {exposureNanos_, 1, 1};
    const auto path = HeadPath::current();
    return Photography(path, rate_hz_, exposureNanos_).exposure(path->frameIndex(index, rate_hz_));
}

std::optional<int64_t> Pictures::newestDrawn(int64_t first, int64_t last, int64_t now) {
    const int64_t newest = newestAt(now);
    first = std::max(first, captureIndex(last, rate_hz_) + 1);
    if (newest < first)
        return {};
    int64_t index = newest;
    if (drawsAhead()) {
        const auto frames = [this](int64_t capture) { return framesOf(capture); };
        drawer_.begin(frames, rate_hz_, delayNanos_);
        while (index >= first && !FrameCache::areDrawn(framesOf(index)))
            index--;
        if (index < first)
            return {};
        int64_t undrawn = 0;
        for (int64_t between = last_ < 0 ? index : last_ + 1; between < index; between++)
            undrawn += FrameCache::areDrawn(framesOf(between)) ? 0 : 1;
        countLeftOut("OpenXR", undrawn);
    } else {
        FrameCache::draw(framesOf(index));
    }
    return last_ = index;
}

void writeIntrinsics(XrPixelSensorFisheyeIntrinsicsML *out) {
    const auto lens = worldLens(number(Key::Tangential), number(Key::Tangential));
    writeShape(lens, out);
    std::copy(lens.k, lens.k + 4, out->radialDistortion);
    out->radialDistortion[4] = 0;
    out->tangentialDistortion[0] = lens.p1;
    out->tangentialDistortion[1] = lens.p2;
}

void writeIntrinsics(const SensorModel &sensor, const Mode &mode, XrPixelSensorPinholeIntrinsicsML *out) {
    const auto lens = sensor.camera == CameraId::Depth
                          ? depthLens()
                          : colorLens(static_cast<uint32_t>(mode.size.width), static_cast<uint32_t>(mode.size.height));
    writeShape(lens, out);
    const double distortion[] = {lens.k1, lens.k2, lens.p1, lens.p2, lens.k3};
    std::copy(std::begin(distortion), std::end(distortion), out->distortion);
}

} // namespace ml2sim::xr
