// The one session, and the spaces made from it.
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
    uint64_t world = 0; ///< Number of the head tracking session whose origin LOCAL has.

    bool isFocused() const { return isRunning && state == XR_SESSION_STATE_FOCUSED; }
};

/** Something with a place in the world at a time; nothing where it is not tracked. */
struct Space : Object {
    std::function<std::optional<Pose>(XrTime)> at;
};

/** Goes over to the state that the keys of session faults ask for. */
void applySessionFaults();

/** Refuses a time that is out of the short memory of poses. */
void checkTime(XrTime time);

/** Where head is in LOCAL, and whether it is tracked. */
Pose headAt(XrTime time);
bool isTracked();

XrPosef toXr(const Pose &pose);
constexpr XrSpaceLocationFlags kLocated =
    XR_SPACE_LOCATION_ORIENTATION_VALID_BIT | XR_SPACE_LOCATION_POSITION_VALID_BIT |
    XR_SPACE_LOCATION_ORIENTATION_TRACKED_BIT | XR_SPACE_LOCATION_POSITION_TRACKED_BIT;

} // namespace ml2sim::xr
