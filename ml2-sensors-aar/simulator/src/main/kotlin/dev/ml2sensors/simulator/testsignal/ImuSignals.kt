package dev.ml2sensors.simulator.testsignal

import dev.ml2sensors.message.Transform
import dev.ml2sensors.message.Vector3
import dev.ml2sensors.message.inverse
import dev.ml2sensors.message.rotate
import dev.ml2sensors.simulator.signal.Signal
import dev.ml2sensors.source.VectorSample

/** Standard gravity in the world, m/s^2 (CGPM 1901). */
private val GRAVITY = Vector3(0.0, 0.0, -9.80665)

/** The earth's magnetic field in central Europe (WMM), in tesla; the world's x axis points to magnetic north. */
private val EARTH_FIELD = Vector3(22e-6, 0.0, -42e-6)

internal fun imuSignals(trajectory: Trajectory): Map<String, Signal> = buildMap {
    for (side in listOf("left", "right", "compute_pack")) {
        val extrinsics = SENSOR_EXTRINSICS.getValue("imu_$side")
        put("accel_$side", vectors(200) { trajectory.at(it).specificForce(extrinsics) })
        put("gyro_$side", vectors(200) { trajectory.at(it).angularVelocity(extrinsics) })
        if (side !=
            "compute_pack"
        ) {
            put("magnetometer_$side", vectors(50) { trajectory.at(it).magneticField(extrinsics) })
        }
    }
}

private fun vectors(rateHz: Int, read: (seconds: Double) -> Vector3) = Signal(rateHz) { capture ->
    val (x, y, z) = read(capture.seconds)
    VectorSample(capture.nanos, x, y, z)
}

/** Returns what an accelerometer at [extrinsics] measures, in its own axes: +9.81 upwards at rest. */
internal fun HeadState.specificForce(extrinsics: Transform): Vector3 {
    val lever = extrinsics.translation
    val ofHead = pose.rotation.inverse().rotate(acceleration - GRAVITY)
    val ofLever = (angularAcceleration cross lever) + (angularVelocity cross (angularVelocity cross lever))
    return extrinsics.rotation.inverse().rotate(ofHead + ofLever)
}

private fun HeadState.angularVelocity(extrinsics: Transform) = extrinsics.rotation.inverse().rotate(angularVelocity)

private fun HeadState.magneticField(extrinsics: Transform) =
    extrinsics.rotation.inverse().rotate(pose.rotation.inverse().rotate(EARTH_FIELD))
