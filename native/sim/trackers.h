// The trackers of all kinds and the snapshots: the poses that they know, which are open, and their reset.
#pragma once

#include <optional>

#include "ml_perception.h"
#include "scene/geometry.h"

namespace ml2sim {

/** Returns Ok if a head tracker is open; otherwise it counts a misuse. */
MLResult checkHeadTracker(const char *function, MLHandle tracker);

/** Returns true if a head tracker is initialized and tracking is not lost. */
bool isHeadPoseKnown();
extern const MLCoordinateFrameUID kHeadFrame;

/** Return the pose of a coordinate frame in the head, or none if no open tracker has the frame or it is not visible. */
std::optional<Pose> eyesInHead(const MLCoordinateFrameUID &id, int64_t mltime);
std::optional<Pose> handsInHead(const MLCoordinateFrameUID &id);
std::optional<Pose> controllerInHead(const MLCoordinateFrameUID &id, int64_t mltime);

bool anyHeadTracker();
bool anyColorTracker();
bool anyEyeTracker();
bool anyHandTracker();
bool anyControllerTracker();
uint32_t openSnapshots();

/** Remove all trackers of a kind, or all snapshots, for ml2sim_reset. */
void resetHeadTracking();
void resetColorTracking();
void resetEyeTracking();
void resetHandTracking();
void resetController();
void resetSnapshots();

} // namespace ml2sim
