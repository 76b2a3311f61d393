// The simulated user: poses of eyes and hands in the head, the same through every interface.
#pragma once

#include <cstdint>

#include "scene/geometry.h"

namespace ml2sim {

enum class Side { Left, Right };

/** Returns the pose between the eyes, with -z at the fixation point 1 m away. It swings by ±10 degrees in 4 s. */
Pose gazeInHead(int64_t mltime);

/** Returns the centre of an eye, with -z at the fixation point. */
Pose eyeInHead(Side eye, int64_t mltime);

/** Returns a joint of XrHandJointEXT. Hands rest in front of the head, each joint 1 cm farther along -z than the last.
 */
Pose jointInHead(Side hand, uint32_t joint);

} // namespace ml2sim
