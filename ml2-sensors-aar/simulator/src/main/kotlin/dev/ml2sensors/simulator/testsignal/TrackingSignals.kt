package dev.ml2sensors.simulator.testsignal

import dev.ml2sensors.message.Quaternion
import dev.ml2sensors.message.Transform
import dev.ml2sensors.message.Vector3
import dev.ml2sensors.message.times
import dev.ml2sensors.message.toPose
import dev.ml2sensors.simulator.signal.Signal
import dev.ml2sensors.source.InputSample
import dev.ml2sensors.source.PoseSample
import dev.ml2sensors.source.PosesSample
import kotlin.math.PI
import kotlin.math.cos
import kotlin.math.sin

/** Returns head, gaze, hands and controller, all in the world frame. */
internal fun trackingSignals(trajectory: Trajectory): Map<String, Signal> = mapOf(
    "head_pose" to Signal(60) { PoseSample(it.nanos, trajectory.at(it.seconds).pose) },
    "gaze" to Signal(60) { PoseSample(it.nanos, trajectory.at(it.seconds).pose * gaze(it.seconds)) },
    "hand_left" to hand(trajectory, side = 1),
    "hand_right" to hand(trajectory, side = -1),
    "controller" to Signal(60) { PoseSample(it.nanos, trajectory.at(it.seconds).pose * palm(it.seconds, side = -1)) },
    "controller_joy" to Signal(60) { input(it.nanos, it.seconds) },
)

/** The gaze: origin between the eyes, x along the viewing direction. */
private fun gaze(seconds: Double): Transform {
    val aside = 0.25 * sin(2 * PI * 0.4 * seconds)
    val down = 0.1 + 0.15 * sin(2 * PI * 0.27 * seconds)
    return SENSOR_EXTRINSICS.getValue("eyes") * Transform(Vector3.ZERO, yaw(aside) * pitch(down))
}

/** Palm, wrist and the joints of each finger from its root, in the order of XR_EXT_hand_tracking. [side] 1 is left. */
private fun hand(trajectory: Trajectory, side: Int) = Signal(30) { capture ->
    val isTracked = (capture.seconds + side) % HAND_PERIOD_SECONDS < HAND_TRACKED_SECONDS
    val palm = trajectory.at(capture.seconds).pose * palm(capture.seconds, side)
    PosesSample(
        capture.nanos,
        JOINTS.map { if (isTracked) (palm * mirrored(it, side)).toPose() else PosesSample.UNTRACKED },
    )
}

/** The trigger is pulled slowly, the buttons are pressed in turns, and a finger circles on the touchpad. */
private fun input(nanos: Long, seconds: Double) = InputSample(
    nanos,
    trigger = (0.5 + 0.5 * sin(2 * PI * 0.5 * seconds)).toFloat(),
    bumper = seconds % 2 < 1,
    menu = seconds % 2 >= 1,
    isTouched = true,
    touchX = (0.5 * sin(2 * PI * 0.25 * seconds)).toFloat(),
    touchY = (0.5 * cos(2 * PI * 0.25 * seconds)).toFloat(),
    force = 0.25f,
)

private const val HAND_PERIOD_SECONDS = 10.0
private const val HAND_TRACKED_SECONDS = 8.0

private fun palm(seconds: Double, side: Int) = Transform(
    Vector3(0.42 + 0.05 * sin(2 * PI * 0.3 * seconds), side * 0.16, -0.2 + 0.06 * sin(2 * PI * 0.5 * seconds)),
    yaw(-side * 0.3) * roll(side * 0.4 * sin(2 * PI * 0.5 * seconds)),
)

/** The joints of a flat left hand in the palm frame: fingers along x, thumb to the right, metres. */
private val JOINTS: List<Vector3> = buildList {
    add(Vector3.ZERO)
    add(Vector3(-0.07, 0.0, 0.0))
    for (step in 0 until 4) add(Vector3(-0.04 + 0.025 * step, -0.03 - 0.012 * step, 0.0))
    for ((finger, length) in listOf(0.085, 0.095, 0.088, 0.07).withIndex()) {
        val across = -0.025 + 0.018 * finger
        add(Vector3(-0.04, across, 0.0))
        for (step in 0 until 4) add(Vector3(0.03 + length * step / 3, across, 0.0))
    }
}

private fun mirrored(joint: Vector3, side: Int) = Transform(joint.copy(y = joint.y * side), Quaternion.IDENTITY)
