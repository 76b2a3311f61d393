// MLDepthCamera*: one stream at a time, with the requested planes.
#include "ml_depth_camera.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "camera_calls.h"
#include "counters.h"
#include "depth_modes.h"
#include "head_path.h"
#include "lazy.h"
#include "ml_unused.h"
#include "render_plans.h"
#include "tracking.h"

namespace ml2sim {
namespace {

constexpr auto kKind = CameraKind::Depth;
constexpr int64_t kDelayNanos = 7000000;

/** The members of a frame for its planes, in the order of the bits of MLDepthCameraFlags and of a cached frame. */
constexpr MLDepthCameraFrameBuffer *MLDepthCameraFrame::*kPlanes[] = {
    &MLDepthCameraFrame::depth_image,     &MLDepthCameraFrame::confidence,
    &MLDepthCameraFrame::flags,           &MLDepthCameraFrame::ambient_raw_depth_image,
    &MLDepthCameraFrame::raw_depth_image,
};
constexpr size_t kPlaneCount = std::size(kPlanes);

CameraConnection connection(kKind, "depth");
DepthChoice choice;
std::shared_ptr<FrameCache> cache;
const PlumbBob lens = depthLens();
uint32_t capabilityLists = 0;

uint32_t stride() { return lens.width * 4; }
size_t planeBytes() { return size_t{stride()} * lens.height; }
size_t planesIn(uint32_t flags) { return static_cast<size_t>(__builtin_popcount(flags)); }

DepthImages imagesIn(uint8_t *frame, uint32_t planes) {
    const auto next = [&](uint32_t flag) -> void * {
        if ((planes & flag) == 0)
            return nullptr;
        return frame + planesIn(planes & (flag - 1)) * planeBytes();
    };
    return {static_cast<float *>(next(MLDepthCameraFlags_DepthImage)),
            static_cast<float *>(next(MLDepthCameraFlags_Confidence)),
            static_cast<uint32_t *>(next(MLDepthCameraFlags_DepthFlags)),
            static_cast<float *>(next(MLDepthCameraFlags_RawDepthImage)),
            static_cast<float *>(next(MLDepthCameraFlags_AmbientRawDepthImage)),
            stride()};
}

RenderPlan renderPlan(const DepthChoice &wanted) {
    const auto headPath = HeadPath::current();
    const auto sigma = static_cast<float>(number(Key::DepthNoise));
    const auto sigmaOfSquare = static_cast<float>(number(Key::DepthNoiseOfSquare));
    const auto noiseSeed = static_cast<uint64_t>(number(Key::Seed)) * 16 + 8;
    const auto &stream = kDepthStreams[wanted.type];
    const auto rays = std::make_shared<Lazy<RayTable>>([] { return RayTable(lens); });
    const bool isRadial = isOn(Key::AssumeRadialDepth), isLargerBetter = isOn(Key::AssumeConfidence);
    const auto draw = [=](size_t index, uint8_t *frame) {
        const Pose camera = compose(headPath->atFrame(index, wanted.delivered_hz).head, mount(Camera::Depth));
        const auto images = imagesIn(frame, wanted.planes);
        renderDepth(*HeadPath::scene(), rays->get(), camera, stream.range, images,
                    {sigma, noiseSeed, index, sigmaOfSquare});
        if (!isRadial && images.distance_m != nullptr)
            std::transform(rays->get().z.begin(), rays->get().z.end(), images.distance_m, images.distance_m,
                           [](float z, float distance) { return std::abs(z) * distance; });
        if (!isLargerBetter && images.confidence != nullptr)
            std::transform(images.confidence, images.confidence + rays->get().z.size(), images.confidence,
                           [](float confidence) { return 1 / (1 + confidence); });
        return planesIn(wanted.planes) * planeBytes();
    };
    const auto inputs = headPath->inputs() + " noise=" + std::to_string(sigma) + "+" + std::to_string(sigmaOfSquare) +
                        " rate=" + std::to_string(wanted.delivered_hz) + " planes=" + std::to_string(wanted.planes) +
                        " radial=" + std::to_string(isRadial) + " confidence=" + std::to_string(isLargerBetter);
    return {stream.name, inputs, planesIn(wanted.planes) * planeBytes(), headPath->frameCount(wanted.delivered_hz),
            draw};
}

void apply(const DepthChoice &wanted) {
    choice = wanted;
    cache = nullptr;
    connection.start({wanted.delivered_hz, kDelayNanos});
}

MLDepthCameraIntrinsics intrinsics() {
    const auto f = [](double value) { return static_cast<float>(value); };
    MLDepthCameraIntrinsics out{};
    out.width = lens.width;
    out.height = lens.height;
    out.focal_length = {f(lens.fx), f(lens.fy)};
    out.principal_point = {f(lens.cx), f(lens.cy)};
    out.fov = f(fovDegrees(lens));
    const double distortion[] = {lens.k1, lens.k2, lens.p1, lens.p2, lens.k3};
    std::memcpy(out.distortion, distortion, sizeof distortion);
    return out;
}

MLDepthCameraFrameBuffer *copyPlane(FrameLease &lease, const uint8_t *pixels) {
    auto *buffer = lease.allocate<MLDepthCameraFrameBuffer>(1);
    auto *data = lease.allocate<uint8_t>(planeBytes());
    std::memcpy(data, pixels, planeBytes());
    *buffer = {lens.width, lens.height, stride(), 4, static_cast<uint32_t>(planeBytes()), data};
    corruptBuffer(kKind, *buffer, buffer->bytes_per_unit);
    return buffer;
}

/** Renders a first frame at the first get: a client that only queries capabilities waits for no scene. */
void beginFilm() {
    if (cache != nullptr)
        return;
    cache = FrameCache::of(renderPlan(choice));
    if (FrameCache::draw({{cache.get(), 0}}))
        connection.leaveOutOverdue();
    HeadPath::current()->start();
}

std::vector<FrameCache::Place> framesOf(int64_t index) {
    return {{cache.get(), HeadPath::current()->frameIndex(index, choice.delivered_hz)}};
}

void lend(int64_t index, MLDepthCameraData *data) {
    const size_t perPlane = FrameLease::rounded(sizeof(MLDepthCameraFrameBuffer)) + FrameLease::rounded(planeBytes());
    auto &lease = connection.lease(data, FrameLease::rounded(2 * sizeof(MLDepthCameraFrame)) + kPlaneCount * perPlane);
    auto *frame = lease.allocate<MLDepthCameraFrame>(2);
    const auto odd = oddFrameAt(kKind, index, 0, 1);
    *frame = {};
    frame->frame_number = connection.frameNumber(index);
    frame->frame_timestamp = captureTime(index, choice.delivered_hz);
    frame->frame_type = corruptId(kKind, choice.type);
    frame->camera_pose = reportedCamera(Camera::Depth, frame->frame_timestamp);
    frame->intrinsics = intrinsics();
    const auto *pixels = cache->frame(HeadPath::current()->frameIndex(index, choice.delivered_hz));
    for (size_t plane = 0; plane < kPlaneCount; plane++) {
        if ((choice.planes >> plane & 1) == 0)
            continue;
        if (isOn(Key::AssumeNullBuffers) || kPlanes[plane] != &MLDepthCameraFrame::flags) {
            frame->*kPlanes[plane] = copyPlane(lease, pixels);
            applyOddFrame(odd, *(frame->*kPlanes[plane]));
        }
        pixels += planeBytes();
    }
    corruptPose(kKind, *frame);
    if (odd == OddFrame::UnknownId)
        frame->frame_type = kNoId;
    if (odd == OddFrame::Size)
        frame->intrinsics.height /= 2;
    frame[1] = frame[0];
    data->frame_count = odd == OddFrame::Duplicate ? 2 : 1;
    data->frames = frame;
    corruptData(kKind, *data);
}

} // namespace

RenderPlan depthRenderPlan(const DepthChoice &wanted) { return renderPlan(wanted); }

bool isDepthCameraOpen() { return connection.isOpen(); }

void resetDepthCamera() {
    connection.reset();
    capabilityLists = 0;
}

} // namespace ml2sim

using namespace ml2sim;

MLResult MLDepthCameraConnect(const MLDepthCameraSettings *settings, MLHandle *out_camera) {
    DepthChoice wanted{};
    return connectCamera(
        connection, __func__, out_camera,
        [&](const char *function) { return chooseDepth(function, settings, &wanted); }, [&] { apply(wanted); });
}

MLResult MLDepthCameraUpdateSettings(MLHandle camera, const MLDepthCameraSettings *settings) {
    DepthChoice wanted{};
    return updateCamera(
        connection, __func__, camera, [&](const char *function) { return chooseDepth(function, settings, &wanted); },
        [&] { apply(wanted); });
}

MLResult MLDepthCameraGetLatestDepthData(MLHandle camera, uint64_t timeout_ms, MLDepthCameraData *inout_data) {
    return getFrames(connection, __func__, camera, timeout_ms, inout_data, {3, framesOf, lend, beginFilm});
}

MLResult MLDepthCameraReleaseDepthData(MLHandle camera, MLDepthCameraData *data) {
    return releaseFrames(connection, __func__, camera, data);
}

MLResult MLDepthCameraGetCapabilities(MLHandle camera, const MLDepthCameraCapabilityFilter *filter,
                                      MLDepthCameraCapabilityList *out_list) {
    const CameraCall call(connection, camera, __func__);
    if (call.isRefused())
        return call.result();
    if (filter == nullptr || out_list == nullptr)
        return refuseArgument(__func__, "filter or out_list is null");
    if (filter->version != 1)
        return refuseVersion(__func__, 1, filter->version);
    auto *capabilities = new MLDepthCameraCapability[std::size(kDepthModes)];
    uint8_t count = 0;
    for (const auto &mode : kDepthModes) {
        const auto &stream = kDepthStreams[mode.type];
        if ((filter->streams & stream.bit) == 0 || !isOnMains(mode))
            continue;
        capabilities[count++] = {1, new MLDepthCameraStreamCapability{stream.bit, stream.least_exposure_us,
                                                                      stream.most_exposure_us, mode.rate}};
    }
    *out_list = {count, capabilities};
    capabilityLists++;
    adjust(Counter::CapabilityLists, 1);
    return MLResult_Ok;
}

MLResult MLDepthCameraReleaseCapabilities(MLHandle camera, MLDepthCameraCapabilityList *list) {
    const CameraCall call(connection, camera, __func__);
    if (call.isRefused())
        return call.result();
    if (list == nullptr || list->capabilities == nullptr || capabilityLists == 0) {
        misuse(ML2SIM_MISUSE_RELEASE, "%s: the list was not got, or is released already", __func__);
        return MLResult_InvalidParam;
    }
    for (uint8_t i = 0; i < list->size; i++)
        delete list->capabilities[i].stream_capabilities;
    delete[] list->capabilities;
    *list = {};
    capabilityLists--;
    adjust(Counter::CapabilityLists, -1);
    return MLResult_Ok;
}

MLResult MLDepthCameraDisconnect(MLHandle camera) {
    const CameraCall call(connection, camera, __func__);
    if (call.isRefused())
        return call.result();
    if (capabilityLists != 0)
        misuse(ML2SIM_MISUSE_UNRELEASED, "%s: %u capability lists were not released", __func__, capabilityLists);
    connection.close();
    return MLResult_Ok;
}
