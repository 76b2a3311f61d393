package dev.ml2sensors.simulator.replay

import dev.ml2sensors.message.Quaternion
import dev.ml2sensors.message.Transform
import dev.ml2sensors.message.Vector3
import dev.ml2sensors.message.normalized
import dev.ml2sensors.message.rotate
import kotlin.math.abs

/** The largest accepted deviation of an entry from that of a rotation; files are written with few digits. */
private const val TOLERANCE = 1e-3

/** The largest accepted deviation of the square of a quaternion's norm from 1; files have three digits or more. */
private const val UNIT_TOLERANCE = 1e-2

private val LAST_ROW = listOf(0.0, 0.0, 0.0, 1.0)

private val AXES = listOf(Vector3(1.0, 0.0, 0.0), Vector3(0.0, 1.0, 0.0), Vector3(0.0, 0.0, 1.0))

/**
 * Returns the transform whose homogeneous 4x4 matrix has the [entries], row by row.
 *
 * @param fails is thrown if they are none; its parameter is what was found.
 */
internal fun rigidTransform(entries: List<Double>, fails: (String) -> RecordingException): Transform {
    val rows = entries.chunked(4)
    val rotation = rows.take(3).map { it.take(3) }
    val isHomogeneous = rows[3].zip(LAST_ROW).all { (found, expected) -> abs(found - expected) < TOLERANCE }
    if (!isHomogeneous || rotation.flatten().any { abs(it) > 1 + TOLERANCE }) throw fails("$rows")
    val quaternion = quaternion(rotation)
    val isRotation = AXES.withIndex().all { (column, axis) ->
        val (x, y, z) = quaternion.rotate(axis)
        listOf(x, y, z).withIndex().all { (row, value) -> abs(value - rotation[row][column]) < TOLERANCE }
    }
    if (!isRotation) throw fails("$rows")
    return Transform(Vector3(rows[0][3], rows[1][3], rows[2][3]), quaternion)
}

/** Returns the unit quaternion, or null if this is none even by few digits. */
internal fun unitQuaternion(x: Double, y: Double, z: Double, w: Double): Quaternion? =
    Quaternion(x, y, z, w).takeIf { abs(x * x + y * y + z * z + w * w - 1) < UNIT_TOLERANCE }?.normalized()

/** Each candidate is the quaternion scaled by four times one of its components. The largest is the most exact. */
private fun quaternion(m: List<List<Double>>): Quaternion {
    val x = m[2][1] - m[1][2]
    val y = m[0][2] - m[2][0]
    val z = m[1][0] - m[0][1]
    val xy = m[0][1] + m[1][0]
    val xz = m[0][2] + m[2][0]
    val yz = m[1][2] + m[2][1]
    val candidates = listOf(
        Quaternion(1 + m[0][0] - m[1][1] - m[2][2], xy, xz, x),
        Quaternion(xy, 1 - m[0][0] + m[1][1] - m[2][2], yz, y),
        Quaternion(xz, yz, 1 - m[0][0] - m[1][1] + m[2][2], z),
        Quaternion(x, y, z, 1 + m[0][0] + m[1][1] + m[2][2]),
    )
    return candidates.maxBy { it.x * it.x + it.y * it.y + it.z * it.z + it.w * it.w }.normalized()
}
