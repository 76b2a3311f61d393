package dev.ml2sensors.source

import kotlin.math.hypot
import kotlin.math.pow

/**
 * The camera [device] in a model that ROS knows.
 *
 * @property intrinsics for CameraInfo: [device] itself, or where its model is the device's own, the `equidistant` lens
 *   with the same K that is nearest to it over the image in the sense of least squares.
 * @property maxResidualPx how far the two are apart at most in the image, in pixels; null when they are the same.
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

/** At one pixel: the angle from the optical axis, where outward is, and where the tangential terms move the point. */
private class Shift(val theta: Double, val outXPx: Double, val outYPx: Double, val xPx: Double, val yPx: Double) {
    /** How much further out the image of this angle is, in focal lengths, per unit of k1 to k4. */
    fun basis(index: Int): Double = theta.pow(2 * index + 3)

    fun distancePx(change: DoubleArray): Double {
        val further = change.indices.sumOf { change[it] * basis(it) }
        return hypot(xPx - further * outXPx, yPx - further * outYPx)
    }
}

/** Over a grid that covers the image to its edges. */
private fun Intrinsics.tangentialShifts(lens: Distortion.FisheyeTangential): List<Shift> = buildList {
    for (row in 0..GRID_CELLS) {
        for (column in 0..GRID_CELLS) {
            val x = (column * width.toDouble() / GRID_CELLS - cx) / fx
            val y = (row * height.toDouble() / GRID_CELLS - cy) / fy
            val radius = hypot(x, y)
            if (radius == 0.0) continue
            val q = radius * radius
            val dx = 2 * lens.p1 * x * y + lens.p2 * (q + 2 * x * x)
            val dy = lens.p1 * (q + 2 * y * y) + 2 * lens.p2 * x * y
            add(Shift(lens.theta(radius), fx * x / radius, fy * y / radius, fx * dx, fy * dy))
        }
    }
}

/** The angle whose image is [radius] focal lengths from the centre before the tangential terms, by Newton's method. */
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
private const val GRID_CELLS = 40

/** Quadratic convergence: lenses that are one to one over the image are exact after five. */
private const val NEWTON_STEPS = 8
