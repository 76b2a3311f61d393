package dev.ml2sensors.simulator.testsignal

import dev.ml2sensors.message.Vector3
import dev.ml2sensors.source.Distortion
import dev.ml2sensors.source.Intrinsics
import java.awt.geom.Point2D
import kotlin.math.atan2
import kotlin.math.hypot
import kotlin.math.max
import kotlin.math.roundToInt

/** 100 degrees across 1016 pixels. */
internal val WORLD_LENS = Intrinsics(
    1016,
    1016,
    fx = 582.0,
    fy = 581.4,
    cx = 506.3,
    cy = 509.8,
    Distortion.Equidistant(k1 = 0.012, k2 = -0.006, k3 = 0.002, k4 = -0.0004),
)

/** 75 by 70 degrees. */
internal val DEPTH_LENS = Intrinsics(
    544,
    480,
    fx = 354.5,
    fy = 342.8,
    cx = 270.7,
    cy = 241.2,
    Distortion.PlumbBob(k1 = -0.03, k2 = 0.01, p1 = 2e-4, p2 = -3e-4, k3 = -0.001),
)

/** The full colour sensor, 75 degrees wide. */
private val COLOR_LENS = Intrinsics(
    4096,
    3072,
    fx = 2668.0,
    fy = 2666.5,
    cx = 2051.4,
    cy = 1530.2,
    Distortion.PlumbBob(k1 = 0.03, k2 = -0.02, p1 = 1e-4, p2 = 2e-4, k3 = 0.003),
)

/** Returns the colour intrinsics at a size: the sensor is scaled to fill that size, then cropped at the centre. */
internal fun colorLens(width: Int, height: Int): Intrinsics {
    val scale = max(width.toDouble() / COLOR_LENS.width, height.toDouble() / COLOR_LENS.height)
    val whole = COLOR_LENS.scaledTo((COLOR_LENS.width * scale).roundToInt(), (COLOR_LENS.height * scale).roundToInt())
    return whole.copy(
        width = width,
        height = height,
        cx = whole.cx - (whole.width - width) / 2.0,
        cy = whole.cy - (whole.height - height) / 2.0,
    )
}

/** The largest angle from the optical axis, in radians, at which a point is projected; all images end before it. */
private const val EDGE = 1.45

/** Returns the pixel of [point] (z forward, x right, y down), or null if it is too far from the optical axis. */
internal fun Intrinsics.project(point: Vector3): Point2D.Double? {
    val aside = hypot(point.x, point.y)
    val theta = atan2(aside, point.z)
    if (theta > EDGE) return null
    return when (val lens = distortion) {
        is Distortion.Equidistant -> {
            val t = theta * theta
            val bent = theta * (1 + t * (lens.k1 + t * (lens.k2 + t * (lens.k3 + t * lens.k4))))
            val scale = if (aside > 0) bent / aside else 0.0
            Point2D.Double(fx * point.x * scale + cx, fy * point.y * scale + cy)
        }

        is Distortion.PlumbBob -> {
            val x = point.x / point.z
            val y = point.y / point.z
            val radial = lens.radial(x, y)
            val (tx, ty) = lens.tangential(x, y)
            Point2D.Double(fx * (x * radial + tx) + cx, fy * (y * radial + ty) + cy)
        }

        is Distortion.FisheyeTangential -> error(
            "expected a simulated lens, equidistant or plumb_bob, found ${lens.name}",
        )
    }
}

/** Returns the ray of the pixel ([u], [v]) of a plumb_bob camera, with z = 1. */
internal fun Intrinsics.ray(u: Double, v: Double): Vector3 {
    val lens = distortion as Distortion.PlumbBob
    val bentX = (u - cx) / fx
    val bentY = (v - cy) / fy
    var x = bentX
    var y = bentY
    repeat(UNDISTORT_STEPS) {
        val radial = lens.radial(x, y)
        val (tx, ty) = lens.tangential(x, y)
        x = (bentX - tx) / radial
        y = (bentY - ty) / radial
    }
    return Vector3(x, y, 1.0)
}

/** Each fixed-point step reduces the error more than tenfold for the lenses above. */
private const val UNDISTORT_STEPS = 12

private fun Distortion.PlumbBob.radial(x: Double, y: Double): Double {
    val q = x * x + y * y
    return 1 + q * (k1 + q * (k2 + q * k3))
}

private fun Distortion.PlumbBob.tangential(x: Double, y: Double): Pair<Double, Double> {
    val q = x * x + y * y
    return Pair(2 * p1 * x * y + p2 * (q + 2 * x * x), p1 * (q + 2 * y * y) + 2 * p2 * x * y)
}
