// The simulated head tracking: its session, its world, and whether it is lost.
#pragma once

#include <cstdint>

#include "ml_types.h"
#include "scene/cameras.h"
#include "settings.h"

namespace ml2sim {

/** Converts a pose from the scene to the world of the current session. */
Pose inWorld(const Pose &inScene);

/** Converts a point from the scene to that world. */
Vec3 pointInWorld(Vec3 inScene);

/** Returns the true pose of the head. */
Pose trueHead(int64_t mltime);

/** Returns the reported pose of the head. While tracking is lost, it is the last tracked pose. */
Pose reportedHead(int64_t mltime);

/** Returns the reported pose of a camera. */
MLTransform reportedCamera(Camera camera, int64_t mltime);

/** Returns the rotation by which a key turns axes. */
Quaternion aboutX(double degrees);

/** Converts a pose to the vendor's structure, with the faults of poses. */
MLTransform toTransform(const Pose &pose);

Tracking trackingNow();

/** Returns the number of the current session, from 0. */
uint64_t sessionNumber();

/** Counts of each MLHeadTrackingMapEvent. Each tracker keeps the counts that it has reported. */
struct MapEvents {
    uint64_t lost = 0, recovered = 0, recoveryFailed = 0, newSession = 0;
};
MapEvents mapEventsSoFar();
uint64_t mapEventsBetween(const MapEvents &before, const MapEvents &after);

/** Applies the keys of head tracking. */
void refreshTracking();

/** Returns to the first session. */
void resetTracking();

} // namespace ml2sim
