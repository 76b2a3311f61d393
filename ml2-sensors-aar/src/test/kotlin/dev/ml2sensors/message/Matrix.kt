package dev.ml2sensors.message

import kotlin.math.PI
import kotlin.math.abs
import kotlin.math.sqrt
import kotlin.random.Random
import kotlin.test.assertEquals

/** A 4x4 matrix, row-major: the other way to compute with transforms. */
internal class Matrix(private vararg val values: Double) {
    operator fun get(row: Int, column: Int) = values[4 * row + column]

    operator fun times(other: Matrix) = of { row, column -> (0..3).sumOf { this[row, it] * other[it, column] } }

    fun transposed() = of { row, column -> this[column, row] }

    companion object {
        fun of(value: (Int, Int) -> Double) = Matrix(*DoubleArray(16) { value(it / 4, it % 4) })

        fun rotation(vararg rows: Int) = of { row, column ->
            when {
                row < 3 && column < 3 -> rows[3 * row + column].toDouble()
                row == column -> 1.0
                else -> 0.0
            }
        }
    }
}

/** Entries of the rotation matrix as in any textbook, from a quaternion of any norm. */
internal fun Transform.toMatrix(): Matrix {
    val (x, y, z, w) = rotation
    val s = 2 / (x * x + y * y + z * z + w * w)
    return Matrix(
        1 - s * (y * y + z * z),
        s * (x * y - z * w),
        s * (x * z + y * w),
        translation.x,
        s * (x * y + z * w),
        1 - s * (x * x + z * z),
        s * (y * z - x * w),
        translation.y,
        s * (x * z - y * w),
        s * (y * z + x * w),
        1 - s * (x * x + y * y),
        translation.z,
        0.0,
        0.0,
        0.0,
        1.0,
    )
}

internal fun assertMatrix(expected: Matrix, found: Matrix) {
    for (row in 0..3) {
        for (column in 0..3) assertEquals(expected[row, column], found[row, column], 1e-12, "[$row, $column]")
    }
}

internal fun assertVector(expected: Vector3, found: Vector3) {
    assertEquals(expected.x, found.x, 1e-12, "x of $found")
    assertEquals(expected.y, found.y, 1e-12, "y of $found")
    assertEquals(expected.z, found.z, 1e-12, "z of $found")
}

/** A quaternion and its negation are the same rotation. */
internal fun assertRotation(expected: Quaternion, found: Quaternion) {
    val dot = expected.x * found.x + expected.y * found.y + expected.z * found.z + expected.w * found.w
    assertEquals(1.0, abs(dot), 1e-12, "expected $expected, but found $found")
}

internal val HALF = sqrt(0.5)

internal fun Random.vector() = Vector3(nextDouble(-5.0, 5.0), nextDouble(-5.0, 5.0), nextDouble(-5.0, 5.0))

/** Returns a quaternion of random norm. */
internal fun Random.quaternion() =
    Quaternion(nextDouble(-PI, PI), nextDouble(-PI, PI), nextDouble(-PI, PI), nextDouble(-PI, PI))

internal fun Random.transform() = Transform(vector(), quaternion().normalized())
