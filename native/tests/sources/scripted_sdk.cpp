#include "scripted_sdk.h"

#include <algorithm>

using scripted::script;

namespace scripted {

Script script;
std::string blocking;
std::atomic<bool> isBlocked{false};
sem_t blocked;
sem_t released;

int Script::countOf(const std::string &function) const {
    return static_cast<int>(std::count(calls.begin(), calls.end(), function));
}

} // namespace scripted

namespace {

constexpr MLHandle kHandle = 0; // A valid one, unlike all ones.

MLResult answer(const char *function) {
    script.calls.emplace_back(function);
    // Only the first thread: the next one finds a library that works
    if (scripted::blocking == function && !scripted::isBlocked.exchange(true)) {
        sem_post(&scripted::blocked);
        sem_wait(&scripted::released);
    }
    const auto found = script.results.find(function);
    return found == script.results.end() ? MLResult_Ok : found->second;
}

template <class Settings> MLResult accept(const char *function, const Settings *settings, Settings &accepted) {
    const auto result = answer(function);
    if (result == MLResult_Ok) {
        accepted = *settings;
    }
    return result;
}

template <class Settings>
MLResult connect(const char *function, const Settings *settings, Settings &accepted, MLHandle *out) {
    *out = kHandle;
    return accept(function, settings, accepted);
}

template <class Frame, class Data>
MLResult get(const char *function, uint64_t timeout_ms, std::vector<Frame> &frames, Data *data) {
    script.timeout_ms = timeout_ms;
    const auto result = answer(function);
    if (result == MLResult_Ok) {
        data->frames = frames.empty() ? nullptr : frames.data();
        data->frame_count = static_cast<uint8_t>(script.frameCount < 0 ? frames.size() : script.frameCount);
    }
    return result;
}

} // namespace

MLResult MLDepthCameraConnect(const MLDepthCameraSettings *settings, MLHandle *out) {
    return connect(__func__, settings, script.depthSettings, out);
}
MLResult MLDepthCameraUpdateSettings(MLHandle, const MLDepthCameraSettings *settings) {
    return accept(__func__, settings, script.depthSettings);
}
MLResult MLDepthCameraGetLatestDepthData(MLHandle, uint64_t timeout_ms, MLDepthCameraData *data) {
    return data->version == 3 ? get(__func__, timeout_ms, script.depthFrames, data) : MLResult_InvalidParam;
}
MLResult MLDepthCameraReleaseDepthData(MLHandle, MLDepthCameraData *) { return answer(__func__); }
MLResult MLDepthCameraDisconnect(MLHandle) { return answer(__func__); }

MLResult MLWorldCameraConnect(const MLWorldCameraSettings *settings, MLHandle *out) {
    return connect(__func__, settings, script.worldSettings, out);
}
MLResult MLWorldCameraUpdateSettings(MLHandle, const MLWorldCameraSettings *settings) {
    return accept(__func__, settings, script.worldSettings);
}
MLResult MLWorldCameraGetLatestWorldCameraData(MLHandle, uint64_t timeout_ms, MLWorldCameraData **data) {
    return *data && (*data)->version == 1 ? get(__func__, timeout_ms, script.worldFrames, *data)
                                          : MLResult_InvalidParam;
}
MLResult MLWorldCameraReleaseCameraData(MLHandle, MLWorldCameraData *) { return answer(__func__); }
MLResult MLWorldCameraDisconnect(MLHandle) { return answer(__func__); }

MLResult MLEyeCameraConnect(const MLEyeCameraSettings *settings, MLHandle *out) {
    return connect(__func__, settings, script.eyeSettings, out);
}
MLResult MLEyeCameraUpdateSettings(MLHandle, const MLEyeCameraSettings *settings) {
    return accept(__func__, settings, script.eyeSettings);
}
MLResult MLEyeCameraGetLatestCameraData(MLHandle, uint64_t timeout_ms, MLEyeCameraData *data) {
    return data->version == 1 ? get(__func__, timeout_ms, script.eyeFrames, data) : MLResult_InvalidParam;
}
MLResult MLEyeCameraReleaseCameraData(MLHandle, MLEyeCameraData *) { return answer(__func__); }
MLResult MLEyeCameraDisconnect(MLHandle) { return answer(__func__); }

MLResult MLPerceptionInitSettings(MLPerceptionSettings *settings) {
    *settings = {};
    return answer(__func__);
}
MLResult MLPerceptionStartup(MLPerceptionSettings *) {
    const auto result = answer(__func__);
    script.isPerceptionStarted |= result == MLResult_Ok;
    return result;
}

MLResult MLPerceptionGetSnapshot(MLSnapshot **) {
    const auto result = answer(__func__);
    return !script.isPerceptionStarted || script.snapshotsRefused-- > 0 ? MLResult_PerceptionSystemNotStarted : result;
}
MLResult MLPerceptionGetPredictedSnapshot(MLTime time, MLSnapshot **) {
    script.snapshotTime = time;
    return answer(__func__);
}
MLResult MLPerceptionReleaseSnapshot(MLSnapshot *) { return answer(__func__); }
MLResult MLSnapshotGetTransform(const MLSnapshot *, const MLCoordinateFrameUID *id, MLTransform *transform) {
    *transform = script.transform;
    return id->data[0] == 11 && id->data[1] == 22 ? answer(__func__) : MLResult_InvalidParam;
}

MLResult MLHeadTrackingCreate(MLHandle *tracker) {
    *tracker = kHandle;
    return answer(__func__);
}
MLResult MLHeadTrackingDestroy(MLHandle) { return answer(__func__); }
MLResult MLHeadTrackingGetStaticData(MLHandle, MLHeadTrackingStaticData *data) {
    *data = {{{11, 22}}};
    return answer(__func__);
}
MLResult MLHeadTrackingGetStateEx(MLHandle, MLHeadTrackingStateEx *state) {
    state->status = script.headStatus;
    return state->version == 1 ? answer(__func__) : MLResult_InvalidParam;
}
MLResult MLHeadTrackingGetMapEvents(MLHandle, uint64_t *events) {
    *events = script.mapEvents;
    script.mapEvents = 0;
    return answer(__func__);
}

MLResult MLCVCameraTrackingCreate(MLHandle *tracker) {
    *tracker = kHandle;
    return answer(__func__);
}
MLResult MLCVCameraGetFramePose(MLHandle, MLHandle, MLCVCameraID, MLTime time, MLTransform *transform) {
    script.cameraPoseTime = time;
    *transform = script.transform;
    return answer(__func__);
}
MLResult MLCVCameraTrackingDestroy(MLHandle) { return answer(__func__); }

MLResult MLTimeConvertMLTimeToSystemTime(MLTime time, struct timespec *monotonic) {
    *monotonic = {(time - scripted::kOffsetNanos) / 1000000000, (time - scripted::kOffsetNanos) % 1000000000};
    return MLResult_Ok;
}
MLResult MLTimeConvertSystemTimeToMLTime(const struct timespec *monotonic, MLTime *time) {
    *time = monotonic->tv_sec * 1000000000 + monotonic->tv_nsec + scripted::kOffsetNanos;
    return MLResult_Ok;
}
