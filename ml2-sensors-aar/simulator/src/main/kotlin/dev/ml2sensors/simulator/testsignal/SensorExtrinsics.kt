package dev.ml2sensors.simulator.testsignal

import dev.ml2sensors.message.Quaternion
import dev.ml2sensors.message.Transform
import dev.ml2sensors.message.Vector3
import dev.ml2sensors.message.times

/**
 * The poses of the sensors in the head frame (x forward, y left, z up; metres). The values are plausible guesses, since
 * the vendor publishes none. Cameras have body axes here; inertial units have Android's axes (x right, y up, z backward,
 * rotated as they are built in). The compute pack is assumed to hang rigidly below the head.
 */
internal val SENSOR_EXTRINSICS: Map<String, Transform> = mapOf(
    "world_center" to extrinsics(0.070, 0.000, 0.020, yawDegrees = 0.0, pitchDegrees = 5.0),
    "world_left" to extrinsics(0.045, 0.075, 0.000, yawDegrees = 40.0, pitchDegrees = 10.0),
    "world_right" to extrinsics(0.045, -0.075, 0.000, yawDegrees = -40.0, pitchDegrees = 10.0),
    "color" to extrinsics(0.072, 0.012, 0.020, yawDegrees = 0.0, pitchDegrees = 5.0),
    "depth" to extrinsics(0.074, -0.014, 0.022, yawDegrees = 0.0, pitchDegrees = 15.0),
    "imu_left" to extrinsics(0.020, 0.070, 0.010, yawDegrees = 12.0, pitchDegrees = 3.0, ANDROID_AXES),
    "imu_right" to extrinsics(0.020, -0.070, 0.010, yawDegrees = -12.0, pitchDegrees = 3.0, ANDROID_AXES),
    "imu_compute_pack" to extrinsics(-0.050, 0.200, -0.700, yawDegrees = 90.0, pitchDegrees = 0.0, ANDROID_AXES),
    "eyes" to extrinsics(0.020, 0.000, -0.030, yawDegrees = 0.0, pitchDegrees = 0.0),
)

/** The axes x right, y up, z backward in the axes x forward, y left, z up. */
private val ANDROID_AXES get() = Quaternion(0.5, -0.5, -0.5, 0.5)

private fun extrinsics(
    x: Double,
    y: Double,
    z: Double,
    yawDegrees: Double,
    pitchDegrees: Double,
    axes: Quaternion = Quaternion.IDENTITY,
) = Transform(
    Vector3(x, y, z),
    yaw(Math.toRadians(yawDegrees)) * pitch(Math.toRadians(pitchDegrees)) * axes,
)
