// The session and its spaces.
#pragma once

#include <functional>
#include <optional>

#include "runtime.h"
#include "scene/geometry.h"

namespace ml2sim::xr {

/** Values of keys that an event has told. */
using Told = std::vector<int64_t>;

/** The events of a kind: wanted by the app or not, and the last one. */
struct Listening {
    bool isEnabled = false;
    Told told;
};

struct Session : Object {
    XrSessionState state = XR_SESSION_STATE_UNKNOWN;
    bool isRunning = false;
    bool hasActionSets = false;
    uint64_t world = 0; ///< Number of the head tracking session whose world is LOCAL.

    Listening localization, fit, calibration;
    size_t map = 0;         ///< The map that was asked for last; at first that of the room.
    int64_t mapReadyAt = 0; ///< MLTime until which the headset is not localized in it.

    bool isFocused() const { return isRunning && state == XR_SESSION_STATE_FOCUSED; }
};

/** A space. Its pose is empty while it is not tracked. */
struct Space : Object {
    std::function<std::optional<Pose>(XrTime)> at;
};

/** Changes the state of the session according to the keys of faults. */
void applySessionFaults();

/** Adds an event for each key of user_events.cpp that has changed since the last one, while the session is in focus. */
void tellUserEvents(XrSession handle, Session &session);

/** A map of the headset. */
struct Map {
    const char *name;
    uint8_t digit; ///< Each byte of its UUID.
    Pose origin;   ///< In the scene.
};

/** Returns the maps that the keys say. */
std::vector<Map> maps();

/** Returns the state of localization. */
XrLocalizationMapStateML mapState(const Session &session);

/** Returns the origin of the session's map as head tracking reports it, while the headset is localized. */
std::optional<Pose> mapOrigin(XrSession handle, XrTime time);

XrLocalizationMapML describe(const Map &map);

/** Adds an event of a space that moves. */
void postSpaceChange(XrSession handle, XrReferenceSpaceType space);

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
