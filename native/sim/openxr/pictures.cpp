#include "pictures.h"

#include <algorithm>
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
    GreyPictures(const RenderPlan &plan, const Mode &mode, int64_t exposureNanos)
        : Pictures(mode.rate_hz, 9000000, exposureNanos), cache_(FrameCache::of(plan)),
          width_(static_cast<uint32_t>(mode.size.width)), height_(static_cast<uint32_t>(mode.size.height)) {
        FrameCache::draw({{cache_.get(), 0}});
    }

    void draw(int64_t index) override { Pictures::draw(*cache_, index); }

    Plane plane(XrPixelSensorFrameTypeML, int64_t index) override {
        return {cache_->frame(frameIndex(index)), width_, height_, 1, width_ * height_};
    }
    uint32_t mostBytes(XrPixelSensorFrameTypeML) const override { return width_ * height_; }

  private:
    std::shared_ptr<FrameCache> cache_;
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
        : Pictures(choice(stream, mode).delivered_hz, 7000000, stream == 0 ? 1600000 : 375000),
          cache_(FrameCache::of(depthRenderPlan(choice(stream, mode)))), pixels_(mode.size.width * mode.size.height),
          width_(static_cast<uint32_t>(mode.size.width)), height_(static_cast<uint32_t>(mode.size.height)) {
        FrameCache::draw({{cache_.get(), 0}});
    }

    void draw(int64_t index) override { Pictures::draw(*cache_, index); }

    Plane plane(XrPixelSensorFrameTypeML type, int64_t index) override {
        const uint8_t *planes = cache_->frame(frameIndex(index));
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

    std::shared_ptr<FrameCache> cache_;
    std::vector<uint32_t> pixels_;
    uint32_t width_, height_;
};

class ColorPictures : public Pictures {
  public:
    ColorPictures(const Mode &mode, bool isMixed)
        : Pictures(mode.rate_hz, 15000000, 8000000), request_{static_cast<uint32_t>(mode.size.width),
                                                              static_cast<uint32_t>(mode.size.height), mode.rate_hz,
                                                              isMixed} {}

    void draw(int64_t index) override { plane(XR_PIXEL_SENSOR_JPEG_ML, index); }

    Plane plane(XrPixelSensorFrameTypeML, int64_t index) override {
        constexpr int64_t kSurely = 1000;
        ml2sim_color_frame frame;
        ml2sim_color(&request_, boottimeOfMlTime(deliveryTimeOf(index) + kSurely), &frame);
        return {frame.jpeg, request_.width, request_.height, 0, frame.jpeg_bytes};
    }
    uint32_t mostBytes(XrPixelSensorFrameTypeML) const override { return request_.width * request_.height * 3 / 2; }

  private:
    const ml2sim_color_request request_;
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
        pictures =
            std::make_shared<GreyPictures>(greyFilm(sensor.camera, stream), mode, stream == 0 ? 5000000 : 1000000);
    HeadPath::current()->start();
    return pictures;
}

int64_t Pictures::captureTimeOf(int64_t index) const { return captureTime(index, rate_hz_); }

int64_t Pictures::deliveryTimeOf(int64_t index) const { return captureTimeOf(index) + delayNanos_; }

int64_t Pictures::newestAt(int64_t mltime) const { return captureIndex(mltime - delayNanos_, rate_hz_); }

size_t Pictures::frameIndex(int64_t index) const { return HeadPath::current()->frameIndex(index, rate_hz_); }

void Pictures::draw(FrameCache &cache, int64_t index) const {
    if (FrameCache::draw({{&cache, frameIndex(index)}}))
        countLeftOut("OpenXR", newestAt(mlTimeNow()) - 1 - index);
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
