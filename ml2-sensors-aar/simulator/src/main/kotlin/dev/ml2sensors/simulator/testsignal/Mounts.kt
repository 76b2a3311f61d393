package dev.ml2sensors.simulator.testsignal

import dev.ml2sensors.message.Quaternion
import dev.ml2sensors.message.Transform
import dev.ml2sensors.message.Vector3
import dev.ml2sensors.message.times

/**
 * Where the sensors are in the head frame (x forward, y left, z up; metres): plausible places, since the vendor
 * publishes none. Cameras have body axes here; inertial units the axes Android gives them (x right, y up, z
 * backward, turned as they are built in). The compute pack is taken to hang rigidly below the head.
 */
internal val MOUNTS: Map<String, Transform> = mapOf(
    "world_center" to mount(0.070, 0.000, 0.020, yawDegrees = 0.0, pitchDegrees = 5.0),
    "world_left" to mount(0.045, 0.075, 0.000, yawDegrees = 40.0, pitchDegrees = 10.0),
    "world_right" to mount(0.045, -0.075, 0.000, yawDegrees = -40.0, pitchDegrees = 10.0),
    "color" to mount(0.072, 0.012, 0.020, yawDegrees = 0.0, pitchDegrees = 5.0),
    "depth" to mount(0.074, -0.014, 0.022, yawDegrees = 0.0, pitchDegrees = 15.0),
    "imu_left" to mount(0.020, 0.070, 0.010, yawDegrees = 12.0, pitchDegrees = 3.0, ANDROID_AXES),
    "imu_right" to mount(0.020, -0.070, 0.010, yawDegrees = -12.0, pitchDegrees = 3.0, ANDROID_AXES),
    "imu_compute_pack" to mount(-0.050, 0.200, -0.700, yawDegrees = 90.0, pitchDegrees = 0.0, ANDROID_AXES),
    "eyes" to mount(0.020, 0.000, -0.030, yawDegrees = 0.0, pitchDegrees = 0.0),
)

/** x right, y up, z backward, in x forward, y left, z up. */
private val ANDROID_AXES get() = Quaternion(0.5, -0.5, -0.5, 0.5)

private fun mount(
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
