// MLEyeTracking*: where each eye is and looks.
#include "ml_eye_tracking.h"

#include "camera_connection.h"
#include "clock.h"
#include "counters.h"
#include "eyes_and_hands.h"
#include "perception.h"
#include "tracking.h"

namespace ml2sim {
namespace {

struct Nothing {};
HandleRegistry<Nothing> trackers;

constexpr uint64_t kFrames = 0x4559455300000000;
constexpr MLEyeTrackingStaticData kStaticData = {{{kFrames, 1}}, {{kFrames, 2}}, {{kFrames, 3}}};

MLResult checkOpen(const char *function, MLHandle handle) {
    if (trackers.find(handle))
        return MLResult_Ok;
    misuse(ML2SIM_MISUSE_HANDLE, "%s: handle %#lx is not open", function, handle);
    return MLResult_InvalidParam;
}

} // namespace

bool anyEyeTracker() {
    return trackers.any([](Nothing) { return true; });
}

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
    if (out_tracker == nullptr)
        return refuseArgument(__func__, "out_tracker is null");
    *out_tracker = ML_INVALID_HANDLE;
    if (const auto result = canCreateTracker())
        return result;
    if (isOn(Key::FaultGazePermission))
        return MLResult_PermissionDenied;
    *out_tracker = newHandle();
    trackers.add(*out_tracker, {});
    adjust(Counter::Handles, 1);
    return MLResult_Ok;
}

MLResult MLEyeTrackingDestroy(MLHandle tracker) {
    if (const auto result = checkOpen(__func__, tracker))
        return result;
    trackers.remove(tracker);
    adjust(Counter::Handles, -1);
    return MLResult_Ok;
}

MLResult MLEyeTrackingGetStaticData(MLHandle tracker, MLEyeTrackingStaticData *out_data) {
    if (const auto result = checkOpen(__func__, tracker))
        return result;
    if (out_data == nullptr)
        return refuseArgument(__func__, "out_data is null");
    *out_data = kStaticData;
    return MLResult_Ok;
}

MLResult MLEyeTrackingGetStateEx(MLHandle tracker, MLEyeTrackingStateEx *inout_state) {
    if (const auto result = checkOpen(__func__, tracker))
        return result;
    if (inout_state == nullptr)
        return refuseArgument(__func__, "inout_state is null");
    if (inout_state->version != 2)
        return refuseVersion(__func__, 2, inout_state->version);
    const bool isSeen = !isOn(Key::FaultGazeClosed);
    const float confidence = isSeen ? 1 : 0;
    *inout_state = {2, confidence, confidence, confidence, !isSeen, !isSeen, 0, mlTimeNow(), confidence, confidence};
    return MLResult_Ok;
}
