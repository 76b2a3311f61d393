package dev.ml2sensors.simulator.replay

import dev.ml2sensors.message.Quaternion
import dev.ml2sensors.message.Transform
import dev.ml2sensors.message.Vector3
import dev.ml2sensors.message.normalized
import dev.ml2sensors.message.rotate
import kotlin.math.abs

/** The largest accepted deviation of an entry from that of a rotation; files are written with few digits. */
private const val TOLERANCE = 1e-3

private val AXES = listOf(Vector3(1.0, 0.0, 0.0), Vector3(0.0, 1.0, 0.0), Vector3(0.0, 0.0, 1.0))

/** Reads `T_BS`, the pose of the sensor in the body frame: a homogeneous 4x4 matrix, row by row. */
internal fun extrinsics(yaml: SensorYaml): Transform {
    val rows = yaml.numbers("T_BS.data", 16).chunked(4)
    val rotation = rows.take(3).map { it.take(3) }
    if (rows[3] != listOf(0.0, 0.0, 0.0, 1.0) || rotation.flatten().any { abs(it) > 1 + TOLERANCE }) {
        throw yaml.error("T_BS.data", "a rigid transform", "$rows")
    }
    val quaternion = quaternion(rotation)
    val isRotation = AXES.withIndex().all { (column, axis) ->
        val (x, y, z) = quaternion.rotate(axis)
        listOf(x, y, z).withIndex().all { (row, value) -> abs(value - rotation[row][column]) < TOLERANCE }
    }
    if (!isRotation) throw yaml.error("T_BS.data", "a rigid transform", "$rows")
    return Transform(Vector3(rows[0][3], rows[1][3], rows[2][3]), quaternion)
}

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
