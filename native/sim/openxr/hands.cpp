// XR_EXT_hand_tracking: the joints of two hands.
#include "entry_points.h"
#include "eyes_and_hands.h"
#include "session.h"

namespace ml2sim::xr {
namespace {

struct HandTracker : Object {
    XrHandEXT hand;
};

bool isSeen(XrHandEXT hand) {
    return (runtime().keys.whole("hands.visible") & (hand == XR_HAND_LEFT_EXT ? 1 : 2)) != 0;
}

} // namespace

XrResult xrCreateHandTrackerEXT(XrSession session, const XrHandTrackerCreateInfoEXT *createInfo,
                                XrHandTrackerEXT *tracker) {
    return entry([&](auto &) {
        find<Session>(session, "session");
        const auto &info = requireType(createInfo, XR_TYPE_HAND_TRACKER_CREATE_INFO_EXT, "XrHandTrackerCreateInfoEXT");
        refuseIf("fault.hands.unsupported", XR_ERROR_FEATURE_UNSUPPORTED);
        auto created = std::make_unique<HandTracker>();
        created->hand = info.hand;
        requireNonNull(tracker, "tracker") = registerObject<XrHandTrackerEXT>(number(session), std::move(created));
    });
}

XrResult xrDestroyHandTrackerEXT(XrHandTrackerEXT tracker) {
    return destroyHandle<HandTracker>(tracker, "hand tracker");
}

XrResult xrLocateHandJointsEXT(XrHandTrackerEXT tracker, const XrHandJointsLocateInfoEXT *locateInfo,
                               XrHandJointLocationsEXT *locations) {
    return entry([&](auto &) {
        const auto hand = find<HandTracker>(tracker, "hand tracker").hand;
        const auto side = hand == XR_HAND_LEFT_EXT ? Side::Left : Side::Right;
        const auto &info = requireType(locateInfo, XR_TYPE_HAND_JOINTS_LOCATE_INFO_EXT, "XrHandJointsLocateInfoEXT");
        auto &out = requireType(locations, XR_TYPE_HAND_JOINT_LOCATIONS_EXT, "XrHandJointLocationsEXT");
        if (out.jointCount != XR_HAND_JOINT_COUNT_EXT)
            misuse(ML2SIM_XR_MISUSE_ARGUMENT, XR_ERROR_VALIDATION_FAILURE, "jointCount is not 26");
        checkTime(info.time);
        const auto base = find<Space>(info.baseSpace, "space").at(info.time);
        out.isActive = base && isTracked() && isSeen(hand);
        for (uint32_t joint = 0; joint < out.jointCount; joint++) {
            auto &location = out.jointLocations[joint];
            location = {};
            if (out.isActive == XR_FALSE || joint == runtime().keys.whole("hands.hidden_joint"))
                continue;
            location.locationFlags = kLocated;
            location.pose = toXr(compose(inverse(*base), compose(headAt(info.time), jointInHead(side, joint))));
            location.radius = 0.01f;
        }
    });
}

} // namespace ml2sim::xr
