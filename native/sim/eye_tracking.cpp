// MLEyeTracking*: the poses of the eyes.
#include "ml_eye_tracking.h"

#include <cstring>

#include "clock.h"
#include "eyes_and_hands.h"
#include "tracker_registry.h"
#include "trackers.h"
#include "tracking.h"

namespace ml2sim {
namespace {

TrackerRegistry<NoState> trackers;

constexpr uint64_t kFrames = 0x4559455300000000;
constexpr MLEyeTrackingStaticData kStaticData = {{{kFrames, 1}}, {{kFrames, 2}}, {{kFrames, 3}}};

} // namespace

bool anyEyeTracker() { return !trackers.isEmpty(); }

void resetEyeTracking() { trackers.clear(); }

std::optional<Pose> eyesInHead(const MLCoordinateFrameUID &id, int64_t mltime) {
    if (id.data[0] != kFrames || !anyEyeTracker())
        return std::nullopt;
    if (id.data[1] == 1)
        return Pose{{}, transform(gazeInHead(mltime), {0, 0, -1})};
    return eyeInHead(id.data[1] == 2 ? Side::Left : Side::Right, mltime);
}

} // namespace ml2sim

using namespace ml2sim;

MLResult MLEyeTrackingCreate(MLHandle *out_tracker) {
    return trackers.create(__func__, out_tracker, Key::FaultGazePermission, MLResult_PermissionDenied);
}

MLResult MLEyeTrackingDestroy(MLHandle tracker) { return trackers.destroy(__func__, tracker); }

MLResult MLEyeTrackingGetStaticData(MLHandle tracker, MLEyeTrackingStaticData *out_data) {
    if (const auto result = trackers.check(__func__, tracker))
        return result;
    if (out_data == nullptr)
        return refuseArgument(__func__, "out_data is null");
    *out_data = kStaticData;
    return MLResult_Ok;
}

MLResult MLEyeTrackingGetStateEx(MLHandle tracker, MLEyeTrackingStateEx *inout_state) {
    if (const auto result = trackers.check(__func__, tracker))
        return result;
    if (const auto result = checkStructure(__func__, inout_state, 2))
        return result;
    if (number(Key::AssumeTrackerLayouts) != inout_state->version)
        return MLResult_InvalidParam;
    const bool isSeen = !isOn(Key::FaultGazeClosed);
    const float confidence = isSeen ? 1 : 0;
    *inout_state = {2, confidence, confidence, confidence, !isSeen, !isSeen, 0, mlTimeNow(), confidence, confidence};
    std::memset(inout_state + 1, 0, static_cast<size_t>(number(Key::AssumeVendorStructs)));
    return MLResult_Ok;
}
