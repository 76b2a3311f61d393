package dev.ml2sensors.stream

import dev.ml2sensors.message.Header
import dev.ml2sensors.message.Imu
import dev.ml2sensors.message.Quaternion
import dev.ml2sensors.message.Vector3
import dev.ml2sensors.source.VectorSample

/**
 * Returns a reading of a gyroscope, an accelerometer or both, in the sensor's own axes; a variance of 0 means unknown.
 */
internal fun imuMessage(
    header: Header,
    angularVelocity: VectorSample?,
    linearAcceleration: VectorSample?,
    angularVelocityVariance: Double,
    accelerationVariance: Double,
): Imu =
    Imu(
        header,
        orientation = Quaternion.IDENTITY,
        orientationCovariance = NOT_MEASURED,
        angularVelocity = angularVelocity?.toVector3() ?: Vector3.ZERO,
        angularVelocityCovariance = if (angularVelocity == null) NOT_MEASURED else diagonal(angularVelocityVariance),
        linearAcceleration = linearAcceleration?.toVector3() ?: Vector3.ZERO,
        linearAccelerationCovariance = if (linearAcceleration == null) NOT_MEASURED else diagonal(accelerationVariance),
    )

internal fun VectorSample.toVector3(): Vector3 = Vector3(x, y, z)

/** In sensor_msgs/Imu, -1 as the first element of the covariance marks a value that is not measured. */
private val NOT_MEASURED = DoubleArray(9).also { it[0] = -1.0 }

private fun diagonal(variance: Double) = doubleArrayOf(variance, 0.0, 0.0, 0.0, variance, 0.0, 0.0, 0.0, variance)
