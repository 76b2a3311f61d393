// MLCVCamera*: the pose of the colour camera.
#include "clock.h"
#include "tracker_registry.h"
#include "trackers.h"
#include "tracking.h"

namespace ml2sim {
namespace {

/** The vendor keeps a short history of unknown length. */
constexpr int64_t kHistoryNanos = kSecond / 2;

TrackerRegistry<NoState> trackers;

} // namespace

bool anyColorTracker() { return !trackers.isEmpty(); }

void resetColorTracking() { trackers.clear(); }

} // namespace ml2sim

using namespace ml2sim;

MLResult MLCVCameraTrackingCreate(MLHandle *out_cv) {
    return trackers.create(__func__, out_cv, Key::FaultColorPermission, MLResult_PermissionDenied);
}

MLResult MLCVCameraGetFramePose(MLHandle cv, MLHandle head_tracker, MLCVCameraID camera, MLTime time,
                                MLTransform *out_transform) {
    if (!isPerceptionStarted())
        return MLResult_PerceptionSystemNotStarted;
    if (const auto result = trackers.check(__func__, cv))
        return result;
    if (const auto result = checkHeadTracker(__func__, head_tracker))
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

MLResult MLCVCameraTrackingDestroy(MLHandle cv) { return trackers.destroy(__func__, cv); }
