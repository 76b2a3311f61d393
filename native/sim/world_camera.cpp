// MLWorldCamera*: three cameras with the same capture times, at most one frame per camera and mode in each get.
#include "ml_world_camera.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <mutex>
#include <vector>

#include "camera_connection.h"
#include "camera_faults.h"
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
    const float gain = type == MLWorldCameraFrameType_LowExposure ? kLowExposureGain : 1;
    const auto sigma = static_cast<float>(number(Key::ImageNoise));
    const auto noiseSeed = static_cast<uint64_t>(number(Key::Seed)) * 16 + position.id;
    const double tangential = number(Key::Tangential);
    const auto shape = lensOfKeys();
    const size_t bytes = size_t{shape.width} * shape.height;
    const auto draw = [=](size_t index, uint8_t *grey) {
        const Pose camera = compose(headPath->atFrame(index, kTiming.rate_hz).head, mount(position.camera));
        const auto rays = raysOf(tangential);
        renderWorld(*HeadPath::scene(), *rays, camera, grey, rays->width, gain, {sigma, noiseSeed, index});
        return bytes;
    };
    const auto inputs = headPath->inputs() + " tangential=" + std::to_string(tangential) +
                        " noise=" + std::to_string(sigma) + " gain=" + std::to_string(gain);
    return {position.name, inputs, bytes, headPath->frameCount(kTiming.rate_hz), draw};
}

MLResult check(const char *function, const MLWorldCameraSettings *settings) {
    if (settings == nullptr)
        return refuseArgument(function, "settings are null");
    if (settings->version != 1)
        return refuseVersion(function, 1, settings->version);
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
    const size_t perFrame = FrameLease::rounded(size_t{stride} * lens.height);
    auto &lease = connection.lease(data, FrameLease::rounded((live.size() + 1) * sizeof(MLWorldCameraFrame)) +
                                             live.size() * perFrame);
    data->frames = lease.allocate<MLWorldCameraFrame>(live.size() + 1);
    data->frame_count = 0;
    for (size_t i = 0; i < live.size(); i++) {
        const auto odd = oddFrameAt(kKind, index, i, live.size());
        data->frames[data->frame_count++] = frameOf(live[i], index, stride, odd, lease);
        if (odd == OddFrame::Duplicate) {
            data->frames[data->frame_count] = data->frames[data->frame_count - 1];
            data->frame_count++;
        }
    }
    corruptData(kKind, *data);
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
    passHold(__func__);
    if (out_cameras == nullptr)
        return refuseArgument(__func__, "out_cameras is null");
    if (const auto result = check(__func__, settings))
        return result;
    if (const auto result = connection.open(out_cameras))
        return result;
    apply(*settings);
    return MLResult_Ok;
}

MLResult MLWorldCameraUpdateSettings(MLHandle cameras, const MLWorldCameraSettings *settings) {
    const CameraCall call(connection, cameras, __func__);
    if (call.isRefused())
        return call.result();
    if (const auto result = check(__func__, settings))
        return result;
    if (connection.isDisconnected())
        return MLResult_UnspecifiedFailure;
    apply(*settings);
    return MLResult_Ok;
}

MLResult MLWorldCameraGetLatestWorldCameraData(MLHandle cameras, uint64_t timeout_ms, MLWorldCameraData **inout_data) {
    const CameraCall call(connection, cameras, __func__);
    if (call.isRefused())
        return call.result();
    if (inout_data == nullptr || *inout_data == nullptr)
        return refuseArgument(__func__, "inout_data must point to an initialised structure of the caller's");
    if ((*inout_data)->version != 1)
        return refuseVersion(__func__, 1, (*inout_data)->version);
    if (const auto result = connection.beginGet())
        return result;
    int64_t index = 0;
    if (const auto result = connection.awaitFrame(timeout_ms, framesOf, &index, anyLive))
        return result;
    lend(index, *inout_data);
    connection.delivered();
    return MLResult_Ok;
}

MLResult MLWorldCameraReleaseCameraData(MLHandle cameras, MLWorldCameraData *data) {
    const CameraCall call(connection, cameras, __func__);
    if (call.isRefused())
        return call.result();
    return connection.release(data);
}

MLResult MLWorldCameraDisconnect(MLHandle cameras) {
    const CameraCall call(connection, cameras, __func__);
    if (call.isRefused())
        return call.result();
    connection.close();
    return MLResult_Ok;
}
