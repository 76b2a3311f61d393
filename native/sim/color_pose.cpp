// MLCVCamera*: where the colour camera was a moment ago.
#include "camera_connection.h"
#include "clock.h"
#include "counters.h"
#include "perception.h"
#include "tracking.h"

namespace ml2sim {
namespace {

/** Only a short history is kept; the vendor does not say how short. */
constexpr int64_t kHistoryNanos = kSecond / 2;

struct Nothing {};
HandleRegistry<Nothing> trackers;

MLResult checkOpen(const char *function, MLHandle handle, bool isOpen) {
    if (isOpen)
        return MLResult_Ok;
    misuse(ML2SIM_MISUSE_HANDLE, "%s: handle %#lx is not open", function, handle);
    return MLResult_InvalidParam;
}

} // namespace

bool anyColorTracker() {
    return trackers.any([](Nothing) { return true; });
}

void resetColorTracking() { trackers.clear(); }

} // namespace ml2sim

using namespace ml2sim;

MLResult MLCVCameraTrackingCreate(MLHandle *out_cv) {
    if (out_cv == nullptr)
        return refuseArgument(__func__, "out_cv is null");
    *out_cv = ML_INVALID_HANDLE;
    if (const auto result = canCreateTracker())
        return result;
    if (isOn(Key::FaultColorPermission))
        return MLResult_PermissionDenied;
    *out_cv = newHandle();
    trackers.add(*out_cv, {});
    adjust(Counter::Handles, 1);
    return MLResult_Ok;
}

MLResult MLCVCameraGetFramePose(MLHandle cv, MLHandle head_tracker, MLCVCameraID camera, MLTime time,
                                MLTransform *out_transform) {
    if (!isPerceptionStarted())
        return MLResult_PerceptionSystemNotStarted;
    if (const auto result = checkOpen(__func__, cv, trackers.find(cv).has_value()))
        return result;
    if (const auto result = checkOpen(__func__, head_tracker, isHeadTrackerOpen(head_tracker)))
        return result;
    if (camera != MLCVCameraID_ColorCamera)
        return refuseArgument(__func__, "camera is not the colour camera");
    if (out_transform == nullptr)
        return refuseArgument(__func__, "out_transform is null");
    if (number(Key::FaultColorPose) == 2)
        return MLResult_UnspecifiedFailure;
    const int64_t now = mlTimeNow();
    if (time > now || time < now - kHistoryNanos || !isHeadPoseKnown() || isOn(Key::FaultColorPose))
        return MLResult_PoseNotFound;
    *out_transform = reportedCamera(Camera::Color, time);
    return MLResult_Ok;
}

MLResult MLCVCameraTrackingDestroy(MLHandle cv) {
    if (const auto result = checkOpen(__func__, cv, trackers.remove(cv)))
        return result;
    adjust(Counter::Handles, -1);
    return MLResult_Ok;
}
