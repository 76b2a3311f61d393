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

/** The changes of k1 to k4 that follow [shifts] best: the normal equations of linear least squares. */
private fun radialFit(shifts: List<Shift>): DoubleArray {
    val system = Array(COEFFICIENTS) { DoubleArray(COEFFICIENTS + 1) }
    for (shift in shifts) {
        val outPx2 = shift.outXPx * shift.outXPx + shift.outYPx * shift.outYPx
        val alongPx2 = shift.xPx * shift.outXPx + shift.yPx * shift.outYPx
        for (row in 0 until COEFFICIENTS) {
            for (column in 0 until COEFFICIENTS) {
                system[row][column] += outPx2 * shift.basis(row) * shift.basis(column)
            }
            system[row][COEFFICIENTS] += alongPx2 * shift.basis(row)
        }
    }
    return solve(system)
}

/** Gauss-Jordan elimination of a positive definite system, whose right-hand side is the last column. */
private fun solve(system: Array<DoubleArray>): DoubleArray {
    for (pivot in system.indices) {
        for (row in system.indices) {
            if (row == pivot) continue
            val factor = system[row][pivot] / system[pivot][pivot]
            for (column in system[row].indices) system[row][column] -= factor * system[pivot][column]
        }
    }
    return DoubleArray(system.size) { system[it].last() / system[it][it] }
}

private const val COEFFICIENTS = 4
private const val GRID_CELLS = 64

/** Each brings a hundred times closer where the terms move a point by a hundredth. */
private const val TANGENTIAL_STEPS = 5

/** Quadratic convergence: lenses that are one to one over the image are exact after five. */
private const val NEWTON_STEPS = 8
