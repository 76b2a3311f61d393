package dev.ml2sensors.source

import org.junit.jupiter.api.Test
import kotlin.test.assertEquals

class IntrinsicsTest {
    private val distortion = Distortion.PlumbBob(1.0, 2.0, 3.0, 4.0, 5.0)

    @Test
    fun theMatrixScalesWithTheImageAndDistortionDoesNot() {
        val full = Intrinsics(4096, 3072, 3000.0, 3100.0, 2040.0, 1530.0, distortion)
        assertEquals(Intrinsics(1024, 1536, 750.0, 1550.0, 510.0, 765.0, distortion), full.scaledTo(1024, 1536))
    }

    @Test
    fun coefficientsAreInTheOrderOfTheirModel() {
        assertEquals("plumb_bob" to listOf(1.0, 2.0, 3.0, 4.0, 5.0), distortion.name to distortion.coefficients)
        val fisheye = Distortion.Equidistant(1.0, 2.0, 3.0, 4.0)
        assertEquals("equidistant" to listOf(1.0, 2.0, 3.0, 4.0), fisheye.name to fisheye.coefficients)
        val device = Distortion.FisheyeTangential(1.0, 2.0, 3.0, 4.0, 5.0, 6.0)
        assertEquals(
            "fisheye_tangential" to listOf(1.0, 2.0, 3.0, 4.0, 5.0, 6.0),
            device.name to device.coefficients,
        )
    }
}
