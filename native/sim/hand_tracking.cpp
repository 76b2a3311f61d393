// MLHandTracking*: the key points of two hands.
#include "ml_hand_tracking.h"

#include <iterator>

#include "clock.h"
#include "eyes_and_hands.h"
#include "tracker_registry.h"
#include "trackers.h"
#include "tracking.h"

namespace ml2sim {
namespace {

TrackerRegistry<NoState> trackers;

constexpr uint64_t kFrames = 0x48414e4453000000;
constexpr uint64_t kPerHand = 100;

/** The joint of XrHandJointEXT for each key point. Both sides of the wrist are at its centre. */
constexpr uint32_t kJoints[] = {
    5,  4,  3,  2,  // thumb, from its tip
    10, 9,  8,  7,  // index
    15, 14, 13, 12, // middle
    20, 19, 18, 17, // ring
    25, 24, 23, 22, // little
    1,  1,  1,  0,  // wrist, its two sides, palm
    6,  11, 16, 21, // bones of the palm, from the index's
};
static_assert(std::size(kJoints) == MLHandTrackingKeyPoint_Count);

MLCoordinateFrameUID frameOf(uint64_t hand, uint64_t keyPoint) { return {{kFrames, hand * kPerHand + keyPoint}}; }

bool isSeen(uint32_t hand) { return (static_cast<uint32_t>(number(Key::HandsVisible)) >> hand & 1) != 0; }

} // namespace

bool anyHandTracker() { return !trackers.isEmpty(); }

void resetHandTracking() { trackers.clear(); }

std::optional<Pose> handsInHead(const MLCoordinateFrameUID &id) {
    if (id.data[0] != kFrames || !anyHandTracker())
        return std::nullopt;
    const auto hand = id.data[1] / kPerHand;
    if (!isSeen(static_cast<uint32_t>(hand)))
        return std::nullopt;
    return jointInHead(hand == MLHandTrackingHandType_Left ? Side::Left : Side::Right, kJoints[id.data[1] % kPerHand]);
}

} // namespace ml2sim

using namespace ml2sim;

MLResult MLHandTrackingCreateEx(const MLHandTrackingSettings *settings, MLHandle *out_tracker) {
    if (const auto result = checkStructure(__func__, settings, 1))
        return result;
    return trackers.create(__func__, out_tracker, Key::FaultHandsPermission, MLResult_PermissionDenied);
}

MLResult MLHandTrackingDestroy(MLHandle tracker) { return trackers.destroy(__func__, tracker); }

MLResult MLHandTrackingGetData(MLHandle tracker, MLHandTrackingData *inout_data) {
    if (const auto result = trackers.check(__func__, tracker))
        return result;
    if (const auto result = checkStructure(__func__, inout_data, 3))
        return result;
    const double hidden = number(Key::HiddenKeyPoint);
    for (uint32_t hand = 0; hand < MLHandTrackingHandType_Count; hand++) {
        auto &state = inout_data->hand_state[hand];
        state.is_hand_detected = isSeen(hand) && trackingNow() == kTracked;
        state.hand_confidence = state.is_hand_detected ? 1 : 0;
        for (uint32_t i = 0; i < MLHandTrackingKeyPoint_Count; i++)
            state.keypoints_mask[i] = state.is_hand_detected && i != hidden;
    }
    inout_data->timestamp_ns = mlTimeNow();
    return MLResult_Ok;
}

MLResult MLHandTrackingGetStaticData(MLHandle tracker, MLHandTrackingStaticData *inout_data) {
    if (const auto result = trackers.check(__func__, tracker))
        return result;
    if (const auto result = checkStructure(__func__, inout_data, 3))
        return result;
    for (uint32_t hand = 0; hand < MLHandTrackingHandType_Count; hand++)
        for (uint32_t i = 0; i < MLHandTrackingKeyPoint_Count; i++) {
            inout_data->hand_cfuids[hand].keypoint_cfuids[i] =
                frameOf(hand, (i + static_cast<uint32_t>(number(Key::AssumeKeyPoints))) % MLHandTrackingKeyPoint_Count);
            inout_data->unfiltered_hand_cfuids[hand].keypoint_cfuids[i] = {};
        }
    return MLResult_Ok;
}
