// ml2sim_color: the frames of the colour camera, encoded once and repeated. On the device Camera2 delivers them.
#include <algorithm>
#include <array>
#include <cstring>
#include <map>
#include <mutex>
#include <vector>

#include "clock.h"
#include "counters.h"
#include "drawer.h"
#include "exposure.h"
#include "frame_cache.h"
#include "head_path.h"
#include "jpeg.h"
#include "lazy.h"
#include "ml2sim.h"
#include "render_plans.h"
#include "scene/render.h"
#include "settings.h"

namespace ml2sim {
namespace {

/** The delay of readout, transfer and encoding. */
constexpr int64_t kDelayNanos = 15000000;
constexpr int64_t kMostLateNanos = 200000000;
constexpr int kMostSkipped = 20;

struct Size {
    uint32_t width, height;
    uint32_t most_hz;
};
constexpr Size kCameraSizes[] = {{640, 480, 60},   {1280, 720, 60},  {1280, 960, 60},
                                 {1440, 1080, 60}, {1920, 1080, 60}, {2048, 1536, 60},
                                 {2880, 2160, 30}, {3840, 2160, 30}, {4096, 3072, 30}};
constexpr Size kMixedSizes[] = {{648, 720, 60}, {972, 1080, 60},  {1944, 2160, 30},
                                {960, 720, 60}, {1440, 1080, 60}, {2880, 2160, 30}};

/** A cached frame: its size, then the JPEG. */
using JpegBytes = uint32_t;
/** Noise of the largest deviation takes 1.2 bytes for a pixel. */
size_t capacity(const ml2sim_color_request &request) { return size_t{request.width} * request.height * 3 / 2 + 65536; }

RenderPlan renderPlan(const ml2sim_color_request &request) {
    const auto headPath = HeadPath::current();
    const bool hologram = request.with_hologram != 0;
    const Photography photography(headPath, request.rate_hz, kColorExposureNanos);
    const auto noiseSeed = static_cast<uint64_t>(number(Key::Seed)) * 16 + 10;
    const auto rays =
        std::make_shared<Lazy<RayTable>>([request] { return RayTable(colorLens(request.width, request.height)); });
    const auto draw = [=](size_t index, uint8_t *frame) -> size_t {
        const Pose camera = compose(headPath->atFrame(index, request.rate_hz).head, mount(Camera::Color));
        std::vector<uint8_t> rgb(size_t{request.width} * request.height * 3);
        const auto &table = rays->get(); // while another camera builds the scene
        renderColor(*HeadPath::scene(), table, camera, hologram, rgb.data(), size_t{request.width} * 3,
                    photography.shot(index, Camera::Color, 1, noiseSeed));
        const auto used = static_cast<JpegBytes>(
            encodeJpeg(rgb.data(), request.width, request.height, frame + sizeof(JpegBytes), capacity(request)));
        std::memcpy(frame, &used, sizeof used);
        return sizeof used + used;
    };
    const auto inputs = headPath->inputs() + " " + photography.inputs() + " " + std::to_string(request.width) + "x" +
                        std::to_string(request.height) + "@" + std::to_string(request.rate_hz);
    return {hologram ? "mixed_reality" : "color", inputs, sizeof(JpegBytes) + capacity(request),
            headPath->frameCount(request.rate_hz), draw};
}

/** The camera in one mode. It leaves out captures that are not drawn when they fall due. */
struct Mode {
    std::mutex mutex;
    int64_t leftOut = 0;
    bool hasStarted = false; ///< The first image waits for the scene, however late it is.
    Drawer drawer;
};

Mode &modeOf(const ml2sim_color_request &request) {
    static std::mutex mutex;
    static std::map<std::array<uint32_t, 4>, Mode> modes;
    const std::lock_guard lock(mutex);
    return modes[{request.width, request.height, request.rate_hz, request.with_hologram}];
}

/** Draws a capture. Returns false if that was done before. */
bool draw(Mode &mode, int64_t index, const CaptureFrames &frames) {
    const auto places = frames(index);
    if (FrameCache::areDrawn(places))
        return false;
    mode.drawer.await(index);
    FrameCache::draw(places);
    return true;
}

/** Returns true if a capture should be left out: soon the device forgets where the camera was. */
bool isTooLate(int64_t index, uint32_t rate_hz) {
    return drawsAhead() && mlTimeNow() - kDelayNanos - captureTime(index, rate_hz) > kMostLateNanos;
}

void awaitDelivery(int64_t index, uint32_t rate_hz) {
    const int64_t delivery = captureTime(index, rate_hz) + kDelayNanos;
    for (uint64_t seen = wakeCount(); mlTimeNow() < delivery; seen = wakeCount())
        waitUntil(delivery, seen);
}

/** Returns the next capture that will be drawn when it falls due. */
int64_t nextDrawn(Mode &mode, int64_t index, bool isLate, uint32_t rate_hz, const CaptureFrames &frames) {
    if (!drawsAhead())
        return isLate ? std::max(index + 1, captureIndex(mlTimeNow() - kDelayNanos, rate_hz)) : index + 1;
    mode.drawer.begin(frames, rate_hz, kDelayNanos);
    int64_t next = isLate ? std::max(index + 1, captureIndex(mlTimeNow() - kDelayNanos, rate_hz)) : index + 1;
    while (next < mode.drawer.index() && !FrameCache::areDrawn(frames(next)))
        next++;
    return next;
}

void writeIntrinsics(const PlumbBob &lens, float out[12]) {
    const double values[] = {double(lens.width),
                             double(lens.height),
                             lens.fx,
                             lens.fy,
                             lens.cx,
                             lens.cy,
                             fovDegrees(lens),
                             lens.k1,
                             lens.k2,
                             lens.p1,
                             lens.p2,
                             lens.k3};
    std::transform(std::begin(values), std::end(values), out, [](double value) { return static_cast<float>(value); });
}

} // namespace

bool isColorOffered(const ml2sim_color_request &request) {
    const bool isRate = request.rate_hz == 15 || request.rate_hz == 30 || request.rate_hz == 60;
    const auto fits = [&](const Size &size) {
        return size.width == request.width && size.height == request.height && request.rate_hz <= size.most_hz;
    };
    if (request.with_hologram != 0)
        return isRate && request.rate_hz != 15 && std::any_of(std::begin(kMixedSizes), std::end(kMixedSizes), fits);
    return isRate && std::any_of(std::begin(kCameraSizes), std::end(kCameraSizes), fits);
}

RenderPlan colorRenderPlan(const ml2sim_color_request &request) { return renderPlan(request); }

} // namespace ml2sim

using namespace ml2sim;

void ml2sim_color_pixels(const uint8_t *jpeg, uint32_t jpeg_bytes, uint8_t *nv21) {
    decodeNv21(jpeg, jpeg_bytes, nv21);
}

int32_t ml2sim_color(const ml2sim_color_request *request, int64_t boottime_nanos, ml2sim_color_frame *out) {
    if (!isColorOffered(*request))
        return -1;
    const uint32_t rate_hz = request->rate_hz;
    auto &mode = modeOf(*request);
    const auto cache = FrameCache::of(renderPlan(*request));
    const auto headPath = HeadPath::current();
    headPath->start();
    const CaptureFrames frames = [&](int64_t capture) {
        return std::vector<FrameCache::Place>{{cache.get(), headPath->frameIndex(capture, rate_hz)}};
    };
    int64_t index = captureIndex(mlTimeOfBoottime(boottime_nanos) - kDelayNanos, rate_hz);
    const std::lock_guard lock(mode.mutex);
    const auto leaveOut = [&](int64_t captures) {
        countLeftOut(request->with_hologram != 0 ? "mixed reality" : "colour", captures);
        mode.leftOut += captures;
    };
    bool isLate = draw(mode, index, frames);
    for (int n = 0; n < kMostSkipped && mode.hasStarted && isLate && isTooLate(index, rate_hz); n++) {
        const int64_t next = nextDrawn(mode, index, isLate, rate_hz, frames);
        leaveOut(next - index);
        index = next;
        awaitDelivery(index, rate_hz);
        isLate = draw(mode, index, frames);
    }
    const uint8_t *frame = cache->frame(headPath->frameIndex(index, rate_hz));
    *out = {};
    std::memcpy(&out->jpeg_bytes, frame, sizeof out->jpeg_bytes);
    out->jpeg = frame + sizeof(JpegBytes);
    out->frame_number = index - mode.leftOut;
    out->capture_mltime = captureTime(index, rate_hz);
    const Photography photography(headPath, rate_hz, kColorExposureNanos);
    out->exposure_nanos = photography.exposure(headPath->frameIndex(index, rate_hz)).nanos;
    const int64_t next = nextDrawn(mode, index, isLate, rate_hz, frames);
    leaveOut(next - index - 1);
    mode.hasStarted = true;
    out->next_boottime = boottimeOfMlTime(captureTime(next, rate_hz) + kDelayNanos);
    writeIntrinsics(colorLens(request->width, request->height), out->intrinsics);
    return 0;
}
