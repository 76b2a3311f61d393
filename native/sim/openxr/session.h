// The session and its spaces.
#pragma once

#include <functional>
#include <optional>

#include "runtime.h"
#include "scene/geometry.h"

namespace ml2sim::xr {

struct Session : Object {
    XrSessionState state = XR_SESSION_STATE_UNKNOWN;
    bool isRunning = false;
    bool hasActionSets = false;
    uint64_t world = 0; ///< Number of the head tracking session whose world is LOCAL.

    bool isFocused() const { return isRunning && state == XR_SESSION_STATE_FOCUSED; }
};

/** A space. Its pose is empty while it is not tracked. */
struct Space : Object {
    std::function<std::optional<Pose>(XrTime)> at;
};

/** Changes the state of the session according to the keys of faults. */
void applySessionFaults();

/** Refuses a time outside the history of poses. */
void checkTime(XrTime time);

/** Return the pose of the head in LOCAL, and whether it is tracked. */
Pose headAt(XrTime time);
bool isTracked();

XrPosef toXr(const Pose &pose);
constexpr XrSpaceLocationFlags kLocated =
    XR_SPACE_LOCATION_ORIENTATION_VALID_BIT | XR_SPACE_LOCATION_POSITION_VALID_BIT |
    XR_SPACE_LOCATION_ORIENTATION_TRACKED_BIT | XR_SPACE_LOCATION_POSITION_TRACKED_BIT;

} // namespace ml2sim::xr
