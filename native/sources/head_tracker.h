/** The vendor's head tracker. It starts the perception system, and the other trackers need it. */
#pragma once

#include "../sdk/perception.h"

/** The function tables that a head tracker needs. */
#define HEAD_TRACKER_AREAS (PERCEPTION_AREAS | 1u << SDK_HEAD)

ml2s_result head_tracker_open(MLHandle *tracker, ml2s_error *error);

/** Closes the head tracker if result, that of creating the other tracker, is a failure. Returns result. */
ml2s_result head_tracker_close_on_failure(ml2s_result result, MLHandle tracker);

/** Closes the head tracker after the other one was destroyed with result. Returns the first failure. */
ml2s_result head_tracker_close_after(ml2s_result result, MLHandle tracker, ml2s_error *error);

ml2s_result head_tracker_close(MLHandle tracker, ml2s_error *error);

/** Sets pose to that of frame at the time of pose. Without one, it stays untracked. */
ml2s_result pose_locate(const MLCoordinateFrameUID *frame, ml2s_reading *pose, ml2s_error *error);
