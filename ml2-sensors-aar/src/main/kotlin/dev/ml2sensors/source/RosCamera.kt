package dev.ml2sensors.source

import kotlin.math.hypot
import kotlin.math.pow

/**
 * The camera [device] in a lens model of ROS.
 *
 * @property intrinsics for CameraInfo: [device] itself, or, if ROS does not have its model, the `equidistant` lens with
 * the same K that fits it best over the image by least squares.
 * @property maxResidualPx the largest difference between both in the image, in pixels; null if they are equal.
 */
internal class RosCamera(val device: Intrinsics) {
    val intrinsics: Intrinsics
    val maxResidualPx: Double?

    init {
        val lens = device.distortion
        if (lens is Distortion.FisheyeTangential) {
            val shifts = device.tangentialShifts(lens)
            val change = radialFit(shifts)
            val fitted = Distortion.Equidistant(
                lens.k1 + change[0],
                lens.k2 + change[1],
                lens.k3 + change[2],
                lens.k4 + change[3],
            )
            intrinsics = device.copy(distortion = fitted)
            maxResidualPx = shifts.maxOf { it.distancePx(change) }
        } else {
            intrinsics = device
            maxResidualPx = null
        }
    }
}

/**
 * The tangential shift of one pixel: the angle from the optical axis, the outward direction, and the shift in pixels.
 */
private class Shift(val theta: Double, val outXPx: Double, val outYPx: Double, val xPx: Double, val yPx: Double) {
    /** Returns the outward change of a pixel at this angle, in focal lengths, per unit of k1 to k4. */
    fun basis(index: Int): Double = theta.pow(2 * index + 3)

    /** Returns the coefficient of k1 to k4 in this pixel's equation, or its right-hand side as the last [column]. */
    fun equation(column: Int): Double {
        val outPx = hypot(outXPx, outYPx)
        return if (column < COEFFICIENTS) outPx * basis(column) else (xPx * outXPx + yPx * outYPx) / outPx
    }

    fun distancePx(change: DoubleArray): Double {
        val further = change.indices.sumOf { change[it] * basis(it) }
        return hypot(xPx - further * outXPx, yPx - further * outYPx)
    }
}

/** Returns the shifts over a grid from the first to the last row and column. */
private fun Intrinsics.tangentialShifts(lens: Distortion.FisheyeTangential): List<Shift> = buildList {
    for (row in 0..GRID_CELLS) {
        for (column in 0..GRID_CELLS) {
            val x = (column * (width - 1.0) / GRID_CELLS - cx) / fx
            val y = (row * (height - 1.0) / GRID_CELLS - cy) / fy
            shift(lens, x, y)?.let(::add)
        }
    }
}

/** Returns the shift at the point ([x], [y]), in focal lengths; null at the centre, where nothing shifts. */
private fun Intrinsics.shift(lens: Distortion.FisheyeTangential, x: Double, y: Double): Shift? {
    var dx = 0.0
    var dy = 0.0
    repeat(TANGENTIAL_STEPS) {
        val fromX = x - dx
        val fromY = y - dy
        val q = fromX * fromX + fromY * fromY
        dx = 2 * lens.p1 * fromX * fromY + lens.p2 * (q + 2 * fromX * fromX)
        dy = lens.p1 * (q + 2 * fromY * fromY) + 2 * lens.p2 * fromX * fromY
    }
    val radius = hypot(x - dx, y - dy)
    if (radius == 0.0) return null
    return Shift(lens.theta(radius), fx * (x - dx) / radius, fy * (y - dy) / radius, fx * dx, fy * dy)
}

/**
 * Returns the angle that is imaged [radius] focal lengths from the centre before the tangential terms, by Newton's
 * method.
 */
private fun Distortion.FisheyeTangential.theta(radius: Double): Double {
    var theta = radius
    repeat(NEWTON_STEPS) {
        val t = theta * theta
        val image = theta * (1 + t * (k1 + t * (k2 + t * (k3 + t * k4))))
        val slope = 1 + t * (3 * k1 + t * (5 * k2 + t * (7 * k3 + t * 9 * k4)))
        theta -= (image - radius) / slope
    }
    return theta
}

/**
 * Returns the changes of k1 to k4 that fit [shifts] best: linear least squares by QR (modified Gram-Schmidt), since the
 * powers of theta are nearly dependent and normal equations would square their condition number.
 */
private fun radialFit(shifts: List<Shift>): DoubleArray {
    val columns = List(COEFFICIENTS + 1) { column -> DoubleArray(shifts.size) { shifts[it].equation(column) } }
    val factors = List(COEFFICIENTS) { DoubleArray(COEFFICIENTS + 1) }
    for (pivot in 0 until COEFFICIENTS) {
        val direction = columns[pivot]
        for (column in pivot + 1..COEFFICIENTS) {
            factors[pivot][column] = direction.dot(columns[column]) / direction.dot(direction)
            for (row in shifts.indices) columns[column][row] -= factors[pivot][column] * direction[row]
        }
    }
    val change = DoubleArray(COEFFICIENTS)
    for (row in COEFFICIENTS - 1 downTo 0) {
        change[row] = factors[row][COEFFICIENTS] - (row + 1 until COEFFICIENTS).sumOf { factors[row][it] * change[it] }
    }
    return change
}

private fun DoubleArray.dot(other: DoubleArray): Double = indices.sumOf { this[it] * other[it] }

private const val COEFFICIENTS = 4
private const val GRID_CELLS = 64

/** Each brings a hundred times closer where the terms move a point by a hundredth. */
private const val TANGENTIAL_STEPS = 5

/** Quadratic convergence: lenses that are one to one over the image are exact after five. */
private const val NEWTON_STEPS = 8
