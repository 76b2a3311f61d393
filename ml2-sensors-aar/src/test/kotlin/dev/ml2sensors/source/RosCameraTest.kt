package dev.ml2sensors.source

import org.junit.jupiter.api.Test
import kotlin.math.PI
import kotlin.math.cos
import kotlin.math.hypot
import kotlin.math.sin
import kotlin.random.Random
import kotlin.test.assertEquals
import kotlin.test.assertIs
import kotlin.test.assertNull
import kotlin.test.assertSame
import kotlin.test.assertTrue

class RosCameraTest {
    /**
     * The greatest residuals of the fit by numpy.linalg.lstsq over 500000 rays, with OpenCV's fisheye projection as the
     * model: p1 to pixels, p2 = 0. With both terms it is up to twice as much.
     */
    @Test
    fun theResidualIsThatOfAFitByOpenCvAndNumpy() {
        for ((p1, residualPx) in mapOf(1e-4 to 0.219, 1e-3 to 2.37)) {
            assertEquals(residualPx, checkNotNull(RosCamera(lens(p1, 0.0)).maxResidualPx), 0.03 * residualPx)
        }
        assertEquals(0.386, checkNotNull(RosCamera(lens(1e-4, 1e-4)).maxResidualPx), 0.01)
    }

    @Test
    fun noRayOfTheImageIsFurtherOffThanStated() {
        for ((p1, p2) in listOf(1e-4 to 1e-4, 1e-3 to 0.0, -1e-3 to 5e-4)) {
            val device = lens(p1, p2)
            val published = RosCamera(device)
            val residualPx = raysInTheImage(device).maxOf { (theta, phi) ->
                val (u, v) = device.project(theta, phi)
                val (x, y) = published.intrinsics.project(theta, phi)
                hypot(u - x, v - y)
            }
            val statedPx = checkNotNull(published.maxResidualPx)
            assertTrue(residualPx in 0.9 * statedPx..1.001 * statedPx, "found $residualPx, stated $statedPx")
        }
    }

    @Test
    fun withoutTangentialTermsTheFitIsTheLensItself() {
        val published = RosCamera(lens(0.0, 0.0))
        assertEquals(0.0, published.maxResidualPx)
        assertEquals(lens(0.0, 0.0).copy(distortion = RADIAL), published.intrinsics)
    }

    @Test
    fun theMatrixIsHeld() {
        val device = lens(1e-3, 1e-3)
        val published = RosCamera(device).intrinsics
        assertIs<Distortion.Equidistant>(published.distortion)
        assertEquals(device, published.copy(distortion = device.distortion))
    }

    @Test
    fun lensesThatRosKnowsStayAsTheyAre() {
        for (distortion in listOf(RADIAL, Distortion.PlumbBob(0.1, -0.2, 0.001, -0.002, 0.05))) {
            val device = lens(0.0, 0.0).copy(distortion = distortion)
            assertSame(device, RosCamera(device).intrinsics)
            assertNull(RosCamera(device).maxResidualPx)
        }
    }

    private fun raysInTheImage(device: Intrinsics): List<Pair<Double, Double>> {
        val random = Random(3)
        return List(200_000) { random.nextDouble(1.45) to random.nextDouble(2 * PI) }.filter { (theta, phi) ->
            val (u, v) = device.project(theta, phi)
            u in 0.0..device.width - 1.0 && v in 0.0..device.height - 1.0
        }
    }

    /** Returns the pixel of a ray at [theta] from the optical axis, [phi] from x to y. */
    private fun Intrinsics.project(theta: Double, phi: Double): Pair<Double, Double> {
        val (k1, k2, k3, k4) = distortion.coefficients
        val (p1, p2) = distortion.coefficients.drop(4).ifEmpty { listOf(0.0, 0.0) }
        val t2 = theta * theta
        val r = theta + theta * t2 * (k1 + k2 * t2 + k3 * t2 * t2 + k4 * t2 * t2 * t2)
        val (x, y) = r * cos(phi) to r * sin(phi)
        return Pair(
            fx * (x + 2 * p1 * x * y + p2 * (r * r + 2 * x * x)) + cx,
            fy * (y + p1 * (r * r + 2 * y * y) + 2 * p2 * x * y) + cy,
        )
    }

    private companion object {
        val RADIAL = Distortion.Equidistant(0.012, -0.006, 0.002, -0.0004)

        fun lens(p1: Double, p2: Double) = Intrinsics(
            1016,
            1016,
            582.0,
            581.4,
            506.3,
            509.8,
            Distortion.FisheyeTangential(RADIAL.k1, RADIAL.k2, RADIAL.k3, RADIAL.k4, p1, p2),
        )
    }
}
