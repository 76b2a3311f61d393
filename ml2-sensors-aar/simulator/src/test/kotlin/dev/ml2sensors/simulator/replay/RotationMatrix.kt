package dev.ml2sensors.simulator.replay

import dev.ml2sensors.message.Quaternion
import kotlin.math.acos
import kotlin.math.cos
import kotlin.math.sin
import kotlin.math.sqrt

/** A rotation as a 3x3 matrix, by Rodrigues' formula. It shares no code with the quaternions under test. */
internal class RotationMatrix(private val m: Array<DoubleArray>) {
    operator fun get(row: Int, column: Int): Double = m[row][column]

    operator fun times(other: RotationMatrix) = of { row, column -> (0..2).sumOf { this[row, it] * other[it, column] } }

    operator fun times(v: DoubleArray) = DoubleArray(3) { row -> (0..2).sumOf { this[row, it] * v[it] } }

    fun transposed() = of { row, column -> this[column, row] }

    /** Returns the rotation about the same axis by [fraction] of the angle, which must be under half a turn. */
    fun scaled(fraction: Double): RotationMatrix {
        val angle = acos(((m[0][0] + m[1][1] + m[2][2] - 1) / 2).coerceIn(-1.0, 1.0))
        if (angle < 1e-9) return of { row, column -> if (row == column) 1.0 else 0.0 }
        val axis = doubleArrayOf(m[2][1] - m[1][2], m[0][2] - m[2][0], m[1][0] - m[0][1])
        return aboutAxis(axis, angle * fraction)
    }

    companion object {
        fun of(entry: (Int, Int) -> Double) = RotationMatrix(Array(3) { row -> DoubleArray(3) { entry(row, it) } })

        fun of(q: Quaternion): RotationMatrix {
            val sine = sqrt(q.x * q.x + q.y * q.y + q.z * q.z)
            return if (sine == 0.0) {
                of { row, column -> if (row == column) 1.0 else 0.0 }
            } else {
                aboutAxis(doubleArrayOf(q.x, q.y, q.z), 2 * kotlin.math.atan2(sine, q.w))
            }
        }

        private fun aboutAxis(direction: DoubleArray, angle: Double): RotationMatrix {
            val norm = sqrt(direction.sumOf { it * it })
            val (x, y, z) = direction.map { it / norm }
            val cross = of { row, column ->
                arrayOf(doubleArrayOf(0.0, -z, y), doubleArrayOf(z, 0.0, -x), doubleArrayOf(-y, x, 0.0))[row][column]
            }
            val square = cross * cross
            return of { row, column ->
                val identity = if (row == column) 1.0 else 0.0
                identity + sin(angle) * cross[row, column] + (1 - cos(angle)) * square[row, column]
            }
        }
    }
}
