// MLEyeCamera*: four cameras on one grid; no pose, no intrinsics.
#include "ml_eye_camera.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <vector>

#include "connection.h"
#include "films.h"
#include "hostile.h"
#include "scene/render.h"
#include "sensors.h"
#include "stage.h"

namespace ml2sim {
namespace {

constexpr auto kKind = CameraKind::Eye;
constexpr Rhythm kRhythm = {30, 6000000};
constexpr uint32_t kBytes = kEyeWidth * kEyeHeight;

struct Position {
    EyeCamera camera; ///< Its value is MLEyeCameraIdentifier's.
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
    std::shared_ptr<Film> film;
};

Connection connection(kKind, "eye");
std::vector<View> views;

FilmPlan planOf(const Position &position) {
    const auto stage = Stage::current();
    const size_t count = stage->filmFrames(kRhythm.rate_hz);
    const auto sigma = static_cast<float>(number(Key::ImageNoise));
    const auto noiseSeed = static_cast<uint64_t>(number(Key::Seed)) * 16 + 9;
    const auto draw = [=](size_t index, uint8_t *grey) {
        const double phase = static_cast<double>(index) / static_cast<double>(count);
        renderEye(position.camera, phase, grey, kEyeWidth, {sigma, noiseSeed, index});
    };
    const auto inputs = "seed=" + std::to_string(noiseSeed) + " noise=" + std::to_string(sigma);
    return {position.name, inputs, kBytes, count, draw};
}

MLResult check(const char *function, const MLEyeCameraSettings *settings) {
    if (settings == nullptr)
        return refuseArgument(function, "settings are null");
    if (settings->version != 1)
        return refuseVersion(function, 1, settings->version);
    if (settings->cameras == 0 || (settings->cameras & ~uint32_t{MLEyeCameraIdentifier_All}) != 0)
        return refuseArgument(function, "cameras are not some of the four");
    return MLResult_Ok;
}

void apply(const MLEyeCameraSettings &settings) {
    views.clear();
    for (const auto &position : kPositions) {
        const auto id = static_cast<MLEyeCameraIdentifier>(position.camera);
        if ((settings.cameras & id) != 0)
            views.push_back({id, Film::of(planOf(position))});
    }
    Stage::current()->begin();
    connection.start(kRhythm);
}

MLEyeCameraFrame frameOf(const View &view, int64_t index, Odd odd, Loan &loan) {
    MLEyeCameraFrame frame{};
    frame.camera_id = spoiltId(kKind, view.id);
    frame.frame_number = index + 100000 * static_cast<int64_t>(view.id);
    frame.timestamp = captureTime(index, kRhythm.rate_hz);
    auto *pixels = loan.take<uint8_t>(kBytes);
    std::memcpy(pixels, view.film->frame(Stage::current()->filmIndex(index, kRhythm.rate_hz)), kBytes);
    frame.frame_buffer = {kEyeWidth, kEyeHeight, kEyeWidth, 1, 1, kBytes, pixels};
    spoilBuffer(kKind, frame.frame_buffer, frame.frame_buffer.bytes_per_pixel);
    if (odd == Odd::UnknownId)
        frame.camera_id = kNoId;
    makeOdd(odd, frame.frame_buffer);
    return frame;
}

void lend(int64_t index, MLEyeCameraData *data) {
    auto &loan = connection.lendTo(data, Loan::rounded((views.size() + 1) * sizeof(MLEyeCameraFrame)) +
                                             views.size() * Loan::rounded(kBytes));
    data->frames = loan.take<MLEyeCameraFrame>(views.size() + 1);
    data->frame_count = 0;
    for (size_t i = 0; i < views.size(); i++) {
        const auto odd = oddOf(kKind, index, i, views.size());
        data->frames[data->frame_count++] = frameOf(views[i], index, odd, loan);
        if (odd == Odd::Duplicate) {
            data->frames[data->frame_count] = data->frames[data->frame_count - 1];
            data->frame_count++;
        }
    }
    spoilData(kKind, *data);
}

} // namespace

FilmPlan eyeFilm(EyeCamera camera) {
    const auto *position = std::find_if(kPositions.begin(), kPositions.end(),
                                        [camera](const Position &candidate) { return candidate.camera == camera; });
    return planOf(*position);
}

bool isEyeCameraOpen() { return connection.isOpen(); }
void resetEyeCamera() { connection.reset(); }

} // namespace ml2sim

using namespace ml2sim;

MLResult MLEyeCameraConnect(const MLEyeCameraSettings *settings, MLHandle *out_cameras) {
    if (out_cameras == nullptr)
        return refuseArgument(__func__, "out_cameras is null");
    if (const auto result = check(__func__, settings))
        return result;
    if (const auto result = connection.open(out_cameras))
        return result;
    apply(*settings);
    return MLResult_Ok;
}

MLResult MLEyeCameraUpdateSettings(MLHandle cameras, const MLEyeCameraSettings *settings) {
    const Call call(connection, cameras, __func__);
    if (call.isRefused())
        return call.result();
    if (const auto result = check(__func__, settings))
        return result;
    if (connection.isGone())
        return MLResult_UnspecifiedFailure;
    apply(*settings);
    return MLResult_Ok;
}

MLResult MLEyeCameraGetLatestCameraData(MLHandle cameras, uint64_t timeout_ms, MLEyeCameraData *inout_data) {
    const Call call(connection, cameras, __func__);
    if (call.isRefused())
        return call.result();
    if (inout_data == nullptr)
        return refuseArgument(__func__, "inout_data is null");
    if (inout_data->version != 1)
        return refuseVersion(__func__, 1, inout_data->version);
    if (const auto result = connection.beginGet())
        return result;
    int64_t index = 0;
    if (const auto result = connection.awaitFrame(timeout_ms, &index))
        return result;
    lend(index, inout_data);
    return MLResult_Ok;
}

MLResult MLEyeCameraReleaseCameraData(MLHandle cameras, MLEyeCameraData *data) {
    const Call call(connection, cameras, __func__);
    if (call.isRefused())
        return call.result();
    return connection.release(data);
}

MLResult MLEyeCameraDisconnect(MLHandle cameras) {
    const Call call(connection, cameras, __func__);
    if (call.isRefused())
        return call.result();
    connection.close();
    return MLResult_Ok;
}
