// What the headset knows of where it is: its session's world, and whether it is lost.
#pragma once

#include <cstdint>

#include "ml_types.h"
#include "scene/cameras.h"
#include "settings.h"

namespace ml2sim {

/** A place of the room in the world of the current session. */
Pose inWorld(const Pose &inScene);

/** A point of the room in that world. */
Vec3 pointInWorld(Vec3 inScene);

/** Where the head truly is. */
Pose trueHead(int64_t mltime);

/** Where the headset takes it to be: while it is not tracked, where it was when that began. */
Pose reportedHead(int64_t mltime);

/** Where it takes a camera to be. */
MLTransform reportedCamera(Camera camera, int64_t mltime);

/** As the vendor's library tells it, faults included. */
MLTransform toTransform(const Pose &pose);

Tracking trackingNow();

/** Counts sessions from 0. */
uint64_t sessionNumber();

/** Bits of MLHeadTrackingMapEvent, each with a count of how often it happened; a cursor per tracker. */
struct MapEvents {
    uint64_t lost = 0, recovered = 0, recoveryFailed = 0, newSession = 0;
};
MapEvents mapEventsSoFar();
uint64_t mapEventsBetween(const MapEvents &before, const MapEvents &after);

/** Takes over what the keys of head tracking say now. */
void refreshTracking();

/** The first session again. */
void resetTracking();

} // namespace ml2sim
