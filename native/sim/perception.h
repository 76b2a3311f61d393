// State of the perception system that the tracking functions share.
#pragma once

#include "ml_perception.h"

namespace ml2sim {

bool isPerceptionStarted();

/** Returns true once the vendor's functions give snapshots, some time after the start. */
bool hasSnapshots();

/** Records the first snapshot. Trackers can be created from then on. */
void markFirstSnapshot();

/** Returns Ok, or why a tracker cannot be created now. */
MLResult canCreateTracker();

/** Stops the system that the caller has started. Returns false if it has not. */
bool stopPerception();

} // namespace ml2sim
