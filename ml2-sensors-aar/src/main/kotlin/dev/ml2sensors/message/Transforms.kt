package dev.ml2sensors.message

import kotlin.math.abs
import kotlin.math.acos
import kotlin.math.atan2
import kotlin.math.pow
import kotlin.math.sin
import kotlin.math.sqrt

/** Returns the rotation by [other] first, then by this. Both and the result are unit quaternions. */
internal operator fun Quaternion.times(other: Quaternion): Quaternion = Quaternion(
    w * other.x + x * other.w + y * other.z - z * other.y,
    w * other.y - x * other.z + y * other.w + z * other.x,
    w * other.z + x * other.y - y * other.x + z * other.w,
    w * other.w - x * other.x - y * other.y - z * other.z,
).normalized()

/** Returns the opposite rotation. */
internal fun Quaternion.inverse(): Quaternion = Quaternion(-x, -y, -z, w)

/**
 * Returns the unit quaternion of the same rotation.
 *
 * @throws IllegalArgumentException if the norm is zero or not finite.
 */
internal fun Quaternion.normalized(): Quaternion {
    val norm = sqrt(x * x + y * y + z * z + w * w)
    require(norm > 0 && norm.isFinite()) { "Expected a rotation, but found $this" }
    return Quaternion(x / norm, y / norm, z / norm, w / norm)
}

/** Returns the angle in rad of the rotation from this to [other], 0 to pi. Both are unit quaternions. */
internal fun Quaternion.angleTo(other: Quaternion): Double {
    val (x, y, z, w) = inverse() * other
    return 2 * atan2(sqrt(x * x + y * y + z * z), abs(w))
}

/** Returns [vector] rotated by this unit quaternion. */
internal fun Quaternion.rotate(vector: Vector3): Vector3 {
    // v + w t + u x t, with u = (x, y, z) and t = 2 u x v
    val tx = 2 * (y * vector.z - z * vector.y)
    val ty = 2 * (z * vector.x - x * vector.z)
    val tz = 2 * (x * vector.y - y * vector.x)
    return Vector3(
        vector.x + w * tx + y * tz - z * ty,
        vector.y + w * ty + z * tx - x * tz,
        vector.z + w * tz + x * ty - y * tx,
    )
}

/** Returns the rotation [fraction] of the shorter way from this to [other], at constant angular velocity. */
internal fun Quaternion.slerp(other: Quaternion, fraction: Double): Quaternion {
    val dot = x * other.x + y * other.y + z * other.z + w * other.w
    val angle = acos(abs(dot).coerceAtMost(1.0))
    // So near each other the chord is as good as the arc, and sin(angle) no divisor
    val isNear = angle < 1e-6
    val here = if (isNear) 1 - fraction else sin((1 - fraction) * angle) / sin(angle)
    val there = (if (isNear) fraction else sin(fraction * angle) / sin(angle)) * if (dot < 0) -1 else 1
    return Quaternion(
        here * x + there * other.x,
        here * y + there * other.y,
        here * z + there * other.z,
        here * w + there * other.w,
    ).normalized()
}

/** Returns the pose in the grandparent frame, for a [child] pose in the frame that has this pose. */
internal operator fun Transform.times(child: Transform): Transform =
    Transform(map(child.translation), rotation * child.rotation)

/** Returns the pose of the parent in the child. */
internal fun Transform.inverse(): Transform {
    val back = rotation.inverse()
    val (x, y, z) = back.rotate(translation)
    return Transform(Vector3(-x, -y, -z), back)
}

/** Returns the distance between both origins in metres. */
internal fun Transform.distanceTo(other: Transform): Double {
    val (x, y, z) = other.translation
    return sqrt((x - translation.x).pow(2) + (y - translation.y).pow(2) + (z - translation.z).pow(2))
}

/** Converts [point] from the child to the parent, metres. */
internal fun Transform.map(point: Vector3): Vector3 {
    val (x, y, z) = rotation.rotate(point)
    return Vector3(x + translation.x, y + translation.y, z + translation.z)
}

/**
 * Returns the pose [fraction] of the way from this to [other], on a straight line and rotating evenly the shorter way.
 */
internal fun Transform.interpolate(other: Transform, fraction: Double): Transform {
    require(fraction in 0.0..1.0) { "Expected a fraction of 0 to 1, but found $fraction" }
    val translation =
        Vector3(
            translation.x + fraction * (other.translation.x - translation.x),
            translation.y + fraction * (other.translation.y - translation.y),
            translation.z + fraction * (other.translation.z - translation.z),
        )
    return Transform(translation, rotation.slerp(other.rotation, fraction))
}

/** Returns the same pose as a [Pose]. */
public fun Transform.toPose(): Pose = Pose(Point(translation.x, translation.y, translation.z), rotation)
