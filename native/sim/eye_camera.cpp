// MLEyeCamera*: four cameras with the same capture times, without pose and intrinsics.
#include "ml_eye_camera.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <vector>

#include "camera_calls.h"
#include "exposure.h"
#include "head_path.h"
#include "render_plans.h"
#include "scene/render.h"

namespace ml2sim {
namespace {

constexpr auto kKind = CameraKind::Eye;
constexpr CaptureTiming kTiming = {30, 6000000};
constexpr uint32_t kBytes = kEyeWidth * kEyeHeight;

struct Position {
    EyeCamera camera; ///< Has the value of its MLEyeCameraIdentifier.
    const char *name;
};
constexpr std::array<Position, 4> kPositions = {{
    {EyeCamera::LeftTemple, "eye_temple_left"},
    {EyeCamera::LeftNasal, "eye_nasal_left"},
    {EyeCamera::RightNasal, "eye_nasal_right"},
    {EyeCamera::RightTemple, "eye_temple_right"},
}};

struct View {
    MLEyeCameraIdentifier id;
    std::shared_ptr<FrameCache> cache;
};

CameraConnection connection(kKind, "eye");
std::vector<View> views;

RenderPlan renderPlan(const Position &position) {
    const auto headPath = HeadPath::current();
    const size_t count = headPath->frameCount(kTiming.rate_hz);
    // The lamps about the display are brighter than the room, so the exposure is always the same.
    const Photography photography(headPath, kTiming.rate_hz, kWorldExposureNanos[0]);
    const auto noiseSeed = static_cast<uint64_t>(number(Key::Seed)) * 16 + 9;
    const auto draw = [=](size_t index, uint8_t *grey) {
        const double phase = static_cast<double>(index) / static_cast<double>(count);
        renderEye(position.camera, phase, grey, kEyeWidth, photography.noise(index, noiseSeed));
        return size_t{kBytes};
    };
    const auto inputs = "seed=" + std::to_string(noiseSeed) + " " + photography.inputs();
    return {position.name, inputs, kBytes, count, draw};
}

MLResult check(const char *function, const MLEyeCameraSettings *settings) {
    if (const auto result = checkStructure(function, settings, 1))
        return result;
    if (settings->cameras == 0 || (settings->cameras & ~uint32_t{MLEyeCameraIdentifier_All}) != 0)
        return refuseArgument(function, "cameras are not some of the four");
    return MLResult_Ok;
}

void apply(const MLEyeCameraSettings &settings) {
    views.clear();
    for (const auto &position : kPositions) {
        const auto id = static_cast<MLEyeCameraIdentifier>(position.camera);
        if ((settings.cameras & id) != 0)
            views.push_back({id, FrameCache::of(renderPlan(position))});
    }
    HeadPath::current()->start();
    connection.start(kTiming);
}

std::vector<FrameCache::Place> framesOf(int64_t index) {
    std::vector<FrameCache::Place> frames;
    for (const auto &view : views)
        frames.push_back({view.cache.get(), HeadPath::current()->frameIndex(index, kTiming.rate_hz)});
    return frames;
}

MLEyeCameraFrame frameOf(const View &view, int64_t index, OddFrame odd, FrameLease &lease) {
    MLEyeCameraFrame frame{};
    frame.camera_id = corruptId(kKind, view.id);
    frame.frame_number = connection.frameNumber(index) + 100000 * static_cast<int64_t>(view.id);
    frame.timestamp = captureTime(index, kTiming.rate_hz);
    auto *pixels = lease.allocate<uint8_t>(kBytes);
    std::memcpy(pixels, view.cache->frame(HeadPath::current()->frameIndex(index, kTiming.rate_hz)), kBytes);
    frame.frame_buffer = {kEyeWidth, kEyeHeight, kEyeWidth, 1, 1, kBytes, pixels};
    corruptBuffer(kKind, frame.frame_buffer, frame.frame_buffer.bytes_per_pixel);
    if (odd == OddFrame::UnknownId)
        frame.camera_id = kNoId;
    applyOddFrame(odd, frame.frame_buffer);
    return frame;
}

void lend(int64_t index, MLEyeCameraData *data) {
    lendFrames<MLEyeCameraFrame>(
        connection, kKind, index, views.size(), kBytes, data,
        [&](size_t i, OddFrame odd, FrameLease &lease) { return frameOf(views[i], index, odd, lease); });
}

} // namespace

RenderPlan eyeRenderPlan(EyeCamera camera) {
    const auto *position = std::find_if(kPositions.begin(), kPositions.end(),
                                        [camera](const Position &candidate) { return candidate.camera == camera; });
    return renderPlan(*position);
}

bool isEyeCameraOpen() { return connection.isOpen(); }
void resetEyeCamera() { connection.reset(); }

} // namespace ml2sim

using namespace ml2sim;

MLResult MLEyeCameraConnect(const MLEyeCameraSettings *settings, MLHandle *out_cameras) {
    return connectCamera(
        connection, __func__, out_cameras, [=](const char *function) { return check(function, settings); },
        [=] { apply(*settings); });
}

MLResult MLEyeCameraUpdateSettings(MLHandle cameras, const MLEyeCameraSettings *settings) {
    return updateCamera(
        connection, __func__, cameras, [=](const char *function) { return check(function, settings); },
        [=] { apply(*settings); });
}

MLResult MLEyeCameraGetLatestCameraData(MLHandle cameras, uint64_t timeout_ms, MLEyeCameraData *inout_data) {
    return getFrames(connection, __func__, cameras, timeout_ms, inout_data, {1, framesOf, lend});
}

MLResult MLEyeCameraReleaseCameraData(MLHandle cameras, MLEyeCameraData *data) {
    return releaseFrames(connection, __func__, cameras, data);
}

MLResult MLEyeCameraDisconnect(MLHandle cameras) { return disconnectCamera(connection, __func__, cameras); }
