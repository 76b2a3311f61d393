// The simulated user: poses of eyes, hands and the hand-held controller in the head, and what is pressed, the same
// through every interface.
#pragma once

#include <cstdint>

#include "scene/geometry.h"

namespace ml2sim {

enum class Side { Left, Right };

/** Returns the pose between the eyes, with -z at the fixation point 1 m away. It swings by ±10 degrees in 4 s. */
Pose gazeInHead(int64_t mltime);

/** Returns the centre of an eye, with -z at the fixation point. */
Pose eyeInHead(Side eye, int64_t mltime);

/** Returns a joint of XrHandJointEXT. Hands rest in front of the head, raised by 60 degrees, palms away from it. */
Pose jointInHead(Side hand, uint32_t joint);

/** Returns the pose of the controller. It goes up and down by 5 cm in front of the head in 2 s, and swings. */
Pose controllerInHead(int64_t mltime);

/** Buttons, trigger and touchpad; of a controller that is not connected all are 0. */
struct ControllerInput {
    bool bumper, menu, isTouched;
    float trigger, x, y, force;
};

/**
 * Returns what is pressed. The trigger goes from 0 to 1 and back in 2 s. The bumper is pressed in the first, the menu
 * button in the second half of each second. A finger circles on the touchpad in 4 s, and is lifted in the last of them.
 */
ControllerInput controllerInputAt(int64_t mltime);

} // namespace ml2sim
