/** Sensors that are the pose of one action. */
#pragma once

#include "../sources/source.h"
#include "actions.h"

/** Belongs to the thread that opened the sensor. */
struct action_pose {
    uint32_t stream; /**< ml2s_stream */
    XrSpace space;   /**< Of actions_create_space. */
};

/** Destroys the space and releases the session. */
ml2s_result action_pose_end(struct action_pose *pose, ml2s_error *error);

/** Adds the current pose, which can be untracked. */
ml2s_result action_pose_poll(const struct action_pose *pose, struct readings *readings, ml2s_error *error);
