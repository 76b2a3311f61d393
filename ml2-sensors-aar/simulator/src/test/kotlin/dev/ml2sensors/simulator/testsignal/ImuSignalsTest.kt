package dev.ml2sensors.simulator.testsignal

import dev.ml2sensors.message.Quaternion
import dev.ml2sensors.message.Transform
import dev.ml2sensors.message.Vector3
import dev.ml2sensors.message.inverse
import dev.ml2sensors.message.rotate
import dev.ml2sensors.message.times
import dev.ml2sensors.simulator.signal.Capture
import dev.ml2sensors.source.VectorSample
import org.junit.jupiter.api.Test
import kotlin.math.abs
import kotlin.math.asin
import kotlin.math.cos
import kotlin.math.sin
import kotlin.math.sqrt
import kotlin.test.assertEquals
import kotlin.test.assertNotEquals
import kotlin.test.assertTrue

class ImuSignalsTest {
    private val trajectory = Trajectory(seed = 3)
    private val units = imuSignals(trajectory)

    @Test
    fun integratedAngularVelocityIsTheRotationOfTheSensor() {
        for (side in listOf("left", "right", "compute_pack")) {
            for (from in listOf(0.0, 12.5, 3_600.0)) {
                val expected = sensor(side, from).rotation.inverse() * sensor(side, from + 1).rotation
                val angle = angleBetween(expected, integrate("gyro_$side", from))
                assertTrue(Math.toDegrees(angle) < 0.01, "$side from $from s: $angle rad")
            }
        }
    }

    @Test
    fun accelerationIsTheSecondDifferenceOfTheSensorsPositionMinusGravity() {
        val h = 1e-3
        for (side in listOf("left", "right", "compute_pack")) {
            for (t in listOf(0.3, 7.7, 100.1)) {
                val middle = sensor(side, t)
                val way = sensor(side, t + h).translation + sensor(side, t - h).translation - middle.translation * 2.0
                val expected = middle.rotation.inverse().rotate(way * (1 / (h * h)) + Vector3(0.0, 0.0, 9.80665))
                assertNear(expected, read("accel_$side", t), 1e-4)
            }
        }
    }

    @Test
    fun atRestAnAccelerometerReadsGravityUpwards() {
        val rest = HeadState(Transform.IDENTITY, Vector3.ZERO, Vector3.ZERO, Vector3.ZERO)
        val up = SENSOR_EXTRINSICS.getValue("imu_left").rotation.inverse().rotate(Vector3(0.0, 0.0, 9.80665))
        assertNear(up, rest.specificForce(SENSOR_EXTRINSICS.getValue("imu_left")), 1e-12)
        val packAxes = Vector3(0.0, 9.80665, 0.0)
        assertNear(packAxes, rest.specificForce(SENSOR_EXTRINSICS.getValue("imu_compute_pack")), 1e-12)
    }

    @Test
    fun magneticFieldIsFixedInTheWorld() {
        for (t in listOf(0.0, 5.0, 50.0)) {
            val field = sensor("right", t).rotation.rotate(read("magnetometer_right", t))
            assertNear(Vector3(22e-6, 0.0, -42e-6), field, 1e-15)
        }
    }

    private fun sensor(side: String, seconds: Double) =
        trajectory.at(seconds).pose * SENSOR_EXTRINSICS.getValue("imu_$side")

    private fun read(stream: String, seconds: Double): Vector3 {
        val sample = units.getValue(stream).read(Capture(0, 0, seconds)) as VectorSample
        return Vector3(sample.x, sample.y, sample.z)
    }

    /** Integrates one second of 200 Hz samples, each taken at the middle of its period. */
    private fun integrate(stream: String, from: Double): Quaternion {
        val period = 1.0 / 200
        return (0 until 200).fold(Quaternion.IDENTITY) { turn, tick ->
            val rate = read(stream, from + (tick + 0.5) * period)
            val speed = sqrt(rate dot rate)
            val (x, y, z) = rate * (sin(speed * period / 2) / speed)
            turn * Quaternion(x, y, z, cos(speed * period / 2))
        }
    }
}

internal fun angleBetween(a: Quaternion, b: Quaternion): Double {
    val difference = a.inverse() * b
    return 2 * asin(sqrt(difference.x * difference.x + difference.y * difference.y + difference.z * difference.z))
}

internal fun assertNear(expected: Vector3, actual: Vector3, tolerance: Double) {
    val difference = actual - expected
    assertTrue(
        maxOf(abs(difference.x), abs(difference.y), abs(difference.z)) <= tolerance,
        "expected $expected, found $actual",
    )
}
