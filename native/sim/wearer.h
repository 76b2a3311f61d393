// Eyes and hands of who wears the headset, in the head: equal by every interface.
#pragma once

#include <cstdint>

#include "scene/geometry.h"

namespace ml2sim {

enum class Side { Left, Right };

/** From between the eyes to where they look, a metre away: to and fro by ten degrees in four seconds. */
Pose gazeInHead(int64_t mltime);

/** The centre of an eye, turned to there. */
Pose eyeInHead(Side eye, int64_t mltime);

/** A hand is at rest before the head: a joint of XrHandJointEXT is a centimetre farther along -z than the last one. */
Pose jointInHead(Side hand, uint32_t joint);

} // namespace ml2sim
