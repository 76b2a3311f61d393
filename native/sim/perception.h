// State of the perception system that the tracking functions share.
#pragma once

#include <optional>

#include "ml_perception.h"
#include "scene/geometry.h"

namespace ml2sim {

bool isPerceptionStarted();

/** Returns true once the vendor's functions give snapshots, some time after the start. */
bool hasSnapshots();

/** Records the first snapshot. Trackers can be created from then on. */
void markFirstSnapshot();

/** Returns Ok, or why a tracker cannot be created now. */
MLResult canCreateTracker();

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

/** Removes all input trackers, which do not need the perception system. */
void resetInput();

/** Stops the perception system and removes all trackers and snapshots, for ml2sim_reset. */
void resetPerception();
void resetHeadTracking();
void resetColorTracking();
void resetEyeTracking();
void resetHandTracking();
void resetControllerTracking();
void resetSnapshots();

} // namespace ml2sim
