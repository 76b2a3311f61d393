// MLWorldCamera*: three cameras with the same capture times, at most one frame per camera and mode in each get.
#include "ml_world_camera.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <mutex>
#include <vector>

#include "camera_calls.h"
#include "exposure.h"
#include "head_path.h"
#include "render_plans.h"
#include "scene/render.h"
#include "tracking.h"

namespace ml2sim {
namespace {

constexpr CaptureTiming kTiming = {30, 9000000};
constexpr float kLowExposureGain = 0.15f;
constexpr uint32_t kModes = MLWorldCameraMode_LowExposure | MLWorldCameraMode_NormalExposure;
constexpr auto kKind = CameraKind::World;

struct Position {
    MLWorldCameraIdentifier id;
    Camera camera;
    const char *name;
};
constexpr std::array<Position, 3> kPositions = {{
    {MLWorldCameraIdentifier_Left, Camera::WorldLeft, "world_left"},
    {MLWorldCameraIdentifier_Right, Camera::WorldRight, "world_right"},
    {MLWorldCameraIdentifier_Center, Camera::WorldCenter, "world_center"},
}};

/** A camera in one mode. */
struct View {
    Position position;
    MLWorldCameraFrameType type;
    std::shared_ptr<FrameCache> cache;

    /** Each camera and mode numbers its own frames from its start. */
    int64_t frameNumber(int64_t number) const {
        return number + 100000 * static_cast<int64_t>(position.id) + 10000 * type;
    }
};

CameraConnection connection(kKind, "world");
std::vector<View> views;
FisheyeTangential lens;

FisheyeTangential lensOfKeys() { return worldLens(number(Key::Tangential), number(Key::Tangential)); }

/** Returns the rays of the world cameras, which have equal lenses. The first call for a lens computes them. */
std::shared_ptr<const RayTable> raysOf(double tangential) {
    static std::mutex computing;
    // Never destroyed: frames may be drawn while the process ends.
    static auto &rays = *new std::shared_ptr<const RayTable>;
    static double ofTangential;
    const std::lock_guard lock(computing);
    if (!rays || ofTangential != tangential)
        rays = std::make_shared<const RayTable>(worldLens(ofTangential = tangential, tangential));
    return rays;
}

RenderPlan renderPlan(const Position &position, MLWorldCameraFrameType type) {
    const auto headPath = HeadPath::current();
    const bool isLow = (type == MLWorldCameraFrameType_LowExposure) != isOn(Key::AssumeNormalExposure);
    const float gain = isLow ? kLowExposureGain : 1;
    const Photography photography(headPath, kTiming.rate_hz, kWorldExposureNanos[isLow ? 1 : 0]);
    const auto noiseSeed = static_cast<uint64_t>(number(Key::Seed)) * 16 + position.id;
    const double tangential = number(Key::Tangential);
    const auto shape = lensOfKeys();
    const size_t bytes = size_t{shape.width} * shape.height;
    const auto draw = [=](size_t index, uint8_t *grey) {
        const Pose camera = compose(headPath->atFrame(index, kTiming.rate_hz).head, mount(position.camera));
        const auto rays = raysOf(tangential);
        renderWorld(*HeadPath::scene(), *rays, camera, grey, rays->width,
                    photography.shot(index, position.camera, gain, noiseSeed));
        return bytes;
    };
    const auto inputs = headPath->inputs() + " tangential=" + std::to_string(tangential) + " " + photography.inputs() +
                        " gain=" + std::to_string(gain);
    return {position.name, inputs, bytes, headPath->frameCount(kTiming.rate_hz), draw};
}

MLResult check(const char *function, const MLWorldCameraSettings *settings) {
    if (const auto result = checkStructure(function, settings, 1))
        return result;
    if (settings->cameras == 0 || (settings->cameras & ~uint32_t{MLWorldCameraIdentifier_All}) != 0)
        return refuseArgument(function, "cameras are not some of Left, Right, Center");
    if (settings->mode == 0 || (settings->mode & ~kModes) != 0)
        return refuseArgument(function, "mode is not some of LowExposure, NormalExposure");
    return MLResult_Ok;
}

/** Renders a first frame of each view, for which the scene must be built, before captures begin. */
void apply(const MLWorldCameraSettings &settings) {
    views.clear();
    lens = lensOfKeys();
    for (const auto &position : kPositions)
        for (const uint32_t type : {MLWorldCameraFrameType_NormalExposure, MLWorldCameraFrameType_LowExposure})
            if ((settings.cameras & position.id) != 0 && (settings.mode & type) != 0)
                views.push_back({position, type, FrameCache::of(renderPlan(position, type))});
    std::vector<FrameCache::Place> first;
    for (const auto &view : views)
        first.push_back({view.cache.get(), 0});
    const bool isDrawn = FrameCache::draw(first);
    HeadPath::current()->start();
    connection.start(kTiming, isDrawn);
}

/** The device captures with low exposure only to track the controller. */
bool isLive(const View &view) {
    return view.type == MLWorldCameraFrameType_NormalExposure || isOn(Key::ControllerTracked);
}

bool anyLive() {
    bool any = false;
    for (const auto &view : views)
        any |= isLive(view);
    return any;
}

std::vector<FrameCache::Place> framesOf(int64_t index) {
    std::vector<FrameCache::Place> frames;
    for (const auto &view : views)
        if (isLive(view))
            frames.push_back({view.cache.get(), HeadPath::current()->frameIndex(index, kTiming.rate_hz)});
    return frames;
}

MLWorldCameraIntrinsics intrinsics() {
    const auto f = [](double value) { return static_cast<float>(value); };
    MLWorldCameraIntrinsics out{};
    out.width = lens.width;
    out.height = lens.height;
    out.focal_length = {f(lens.fx), f(lens.fy)};
    out.principal_point = {f(lens.cx), f(lens.cy)};
    out.fov = f(fovDegrees(lens));
    std::copy_n(lens.k, 4, out.radial_distortion);
    out.tangential_distortion[0] = lens.p1;
    out.tangential_distortion[1] = lens.p2;
    return out;
}

/** Copies rows to a stride, and fills the padding with values that are no pixels. */
uint8_t *copyRows(FrameLease &lease, const uint8_t *grey, uint32_t stride) {
    constexpr uint8_t kBetweenRows = 0xee;
    auto *rows = lease.allocate<uint8_t>(size_t{stride} * lens.height);
    for (uint32_t y = 0; y < lens.height; y++) {
        std::memcpy(rows + size_t{y} * stride, grey + size_t{y} * lens.width, lens.width);
        std::memset(rows + size_t{y} * stride + lens.width, kBetweenRows, stride - lens.width);
    }
    return rows;
}

MLWorldCameraFrame frameOf(const View &view, int64_t index, uint32_t stride, OddFrame odd, FrameLease &lease) {
    MLWorldCameraFrame frame{};
    frame.id = corruptId(kKind, view.position.id);
    frame.frame_number = view.frameNumber(connection.frameNumber(index));
    frame.timestamp = captureTime(index, kTiming.rate_hz);
    frame.intrinsics = intrinsics();
    frame.camera_pose = reportedCamera(view.position.camera, frame.timestamp);
    const auto *grey = view.cache->frame(HeadPath::current()->frameIndex(index, kTiming.rate_hz));
    frame.frame_buffer = {lens.width, lens.height, stride, 1, stride * lens.height, copyRows(lease, grey, stride)};
    frame.frame_type = view.type;
    corruptBuffer(kKind, frame.frame_buffer, frame.frame_buffer.bytes_per_pixel);
    corruptPose(kKind, frame);
    if (odd == OddFrame::UnknownId)
        frame.id = kNoId;
    applyOddFrame(odd, frame.frame_buffer);
    return frame;
}

void lend(int64_t index, MLWorldCameraData *data) {
    std::vector<View> live;
    for (const auto &view : views)
        if (isLive(view))
            live.push_back(view);
    const uint32_t stride = lens.width + static_cast<uint32_t>(number(Key::StridePadding));
    lendFrames<MLWorldCameraFrame>(
        connection, kKind, index, live.size(), size_t{stride} * lens.height, data,
        [&](size_t i, OddFrame odd, FrameLease &lease) { return frameOf(live[i], index, stride, odd, lease); });
}

} // namespace

RenderPlan worldRenderPlan(MLWorldCameraIdentifier camera, MLWorldCameraFrameType exposure) {
    const auto *position = std::find_if(kPositions.begin(), kPositions.end(),
                                        [camera](const Position &candidate) { return candidate.id == camera; });
    return renderPlan(*position, exposure);
}

bool isWorldCameraOpen() { return connection.isOpen(); }
void resetWorldCamera() { connection.reset(); }

} // namespace ml2sim

using namespace ml2sim;

MLResult MLWorldCameraConnect(const MLWorldCameraSettings *settings, MLHandle *out_cameras) {
    return connectCamera(
        connection, __func__, out_cameras, [=](const char *function) { return check(function, settings); },
        [=] { apply(*settings); });
}

MLResult MLWorldCameraUpdateSettings(MLHandle cameras, const MLWorldCameraSettings *settings) {
    return updateCamera(
        connection, __func__, cameras, [=](const char *function) { return check(function, settings); },
        [=] { apply(*settings); });
}

MLResult MLWorldCameraGetLatestWorldCameraData(MLHandle cameras, uint64_t timeout_ms, MLWorldCameraData **inout_data) {
    return getFrames(connection, __func__, cameras, timeout_ms, inout_data == nullptr ? nullptr : *inout_data,
                     {1, framesOf, lend, [] {}, anyLive});
}

MLResult MLWorldCameraReleaseCameraData(MLHandle cameras, MLWorldCameraData *data) {
    return releaseFrames(connection, __func__, cameras, data);
}

MLResult MLWorldCameraDisconnect(MLHandle cameras) { return disconnectCamera(connection, __func__, cameras); }
