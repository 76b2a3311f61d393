package dev.ml2sensors.simulator.testsignal

import dev.ml2sensors.message.Quaternion
import dev.ml2sensors.message.Vector3
import kotlin.math.cos
import kotlin.math.sin

internal operator fun Vector3.plus(other: Vector3) = Vector3(x + other.x, y + other.y, z + other.z)

internal operator fun Vector3.minus(other: Vector3) = Vector3(x - other.x, y - other.y, z - other.z)

internal operator fun Vector3.times(factor: Double) = Vector3(x * factor, y * factor, z * factor)

internal infix fun Vector3.cross(other: Vector3) =
    Vector3(y * other.z - z * other.y, z * other.x - x * other.z, x * other.y - y * other.x)

internal infix fun Vector3.dot(other: Vector3) = x * other.x + y * other.y + z * other.z

/** Rotation by [radians] about the x axis. */
internal fun roll(radians: Double) = Quaternion(sin(radians / 2), 0.0, 0.0, cos(radians / 2))

/** Rotation by [radians] about the y axis; positive looks down. */
internal fun pitch(radians: Double) = Quaternion(0.0, sin(radians / 2), 0.0, cos(radians / 2))

/** Rotation by [radians] about the z axis; positive looks left. */
internal fun yaw(radians: Double) = Quaternion(0.0, 0.0, sin(radians / 2), cos(radians / 2))
