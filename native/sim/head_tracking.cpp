// MLHeadTracking*: the state of head tracking.
#include "clock.h"
#include "tracker_registry.h"
#include "trackers.h"
#include "tracking.h"

namespace ml2sim {
namespace {

constexpr int64_t kInitializingNanos = 3 * kSecond / 10;

struct Tracker {
    int64_t createdAt; ///< MLTime
    MapEvents seen;

    bool isInitializing() const { return mlTimeNow() < createdAt + kInitializingNanos; }
};

TrackerRegistry<Tracker> trackers;

uint32_t statusOf(const Tracker &tracker) {
    if (tracker.isInitializing())
        return MLHeadTrackingStatus_Initializing;
    switch (trackingNow()) {
    case kRelocalizing:
        return MLHeadTrackingStatus_Relocalizing;
    case kLost:
        return MLHeadTrackingStatus_Invalid;
    default:
        return MLHeadTrackingStatus_Valid;
    }
}

} // namespace

const MLCoordinateFrameUID kHeadFrame = {{0x4845414400000000, 1}};

MLResult checkHeadTracker(const char *function, MLHandle tracker) { return trackers.check(function, tracker); }

bool isHeadPoseKnown() {
    return trackingNow() == kTracked && trackers.any([](const Tracker &tracker) { return !tracker.isInitializing(); });
}

bool anyHeadTracker() { return !trackers.isEmpty(); }

void resetHeadTracking() { trackers.clear(); }

} // namespace ml2sim

using namespace ml2sim;

MLResult MLHeadTrackingCreate(MLHandle *out_tracker) {
    const auto most = static_cast<size_t>(number(Key::AssumeHeadTrackers));
    if (most != 0 && trackers.count() >= most)
        return MLResult_UnspecifiedFailure;
    return trackers.create(__func__, out_tracker, Key::FaultHeadCreate, MLResult_UnspecifiedFailure,
                           {mlTimeNow(), mapEventsSoFar()});
}

MLResult MLHeadTrackingDestroy(MLHandle tracker) { return trackers.destroy(__func__, tracker); }

MLResult MLHeadTrackingGetStaticData(MLHandle tracker, MLHeadTrackingStaticData *out_data) {
    if (const auto result = trackers.check(__func__, tracker))
        return result;
    if (out_data == nullptr)
        return refuseArgument(__func__, "out_data is null");
    out_data->coord_frame_head = kHeadFrame;
    return MLResult_Ok;
}

MLResult MLHeadTrackingGetStateEx(MLHandle tracker, MLHeadTrackingStateEx *inout_state) {
    auto found = trackers.find(__func__, tracker);
    if (!found)
        return MLResult_InvalidParam;
    if (const auto result = checkStructure(__func__, inout_state, 1))
        return result;
    inout_state->status = statusOf(*found);
    inout_state->confidence =
        inout_state->status == MLHeadTrackingStatus_Valid ? static_cast<float>(number(Key::FaultHeadConfidence)) : 0;
    inout_state->error = static_cast<uint32_t>(number(Key::FaultHeadErrors));
    if (trackingNow() != kTracked)
        inout_state->error |= MLHeadTrackingErrorFlag_NotEnoughFeatures;
    return MLResult_Ok;
}

MLResult MLHeadTrackingGetMapEvents(MLHandle tracker, uint64_t *out_events) {
    auto found = trackers.find(__func__, tracker);
    if (!found)
        return MLResult_InvalidParam;
    if (out_events == nullptr)
        return refuseArgument(__func__, "out_events is null");
    const auto now = mapEventsSoFar();
    *out_events = mapEventsBetween(found->seen, now);
    found->seen = now;
    trackers.set(tracker, *found);
    return MLResult_Ok;
}
