package dev.ml2sensors.simulator.testsignal

import dev.ml2sensors.message.Vector3
import org.junit.jupiter.api.Test
import kotlin.test.assertEquals
import kotlin.test.assertNotNull
import kotlin.test.assertNull

class LensesTest {
    @Test
    fun projectionIsThatOfOpenCv() {
        // cv2.fisheye.projectPoints and cv2.projectPoints, 4.12
        val expected = mapOf(
            WORLD_LENS to
                listOf(674.1013035267393 to 398.0477916718829, 247.45475308619984 to 725.2819967864883),
            DEPTH_LENS to
                listOf(376.61149799904996 to 172.92268638631998, 95.2701894214604 to 382.55930974825276),
        )
        for ((lens, pixels) in expected) {
            for ((point, pixel) in POINTS zip pixels) {
                val projected = assertNotNull(lens.project(point))
                assertEquals(pixel.first, projected.x, 1e-9)
                assertEquals(pixel.second, projected.y, 1e-9)
            }
        }
    }

    @Test
    fun rayIsTheInverseOfProjection() {
        for (u in 0..543 step 60) {
            for (v in 0..479 step 60) {
                val pixel = assertNotNull(DEPTH_LENS.project(DEPTH_LENS.ray(u.toDouble(), v.toDouble())))
                assertEquals(u.toDouble(), pixel.x, 1e-6)
                assertEquals(v.toDouble(), pixel.y, 1e-6)
            }
        }
    }

    @Test
    fun pointsFarOffAxisOrBehindTheCameraHaveNoPixel() {
        assertNull(WORLD_LENS.project(Vector3(1.0, 0.0, 0.01)))
        assertNull(DEPTH_LENS.project(Vector3(0.0, 0.1, -1.0)))
    }

    @Test
    fun colorIntrinsicsAreScaledAndCroppedAtTheCentre() {
        val hd = colorLens(1920, 1080)
        assertEquals(2668.0 * 1920 / 4096, hd.fx, 1e-9)
        assertEquals(2666.5 * 1440 / 3072, hd.fy, 1e-9)
        assertEquals(1530.2 * 1440 / 3072 - 180, hd.cy, 1e-9)
        val portrait = colorLens(648, 720)
        assertEquals(2051.4 * 960 / 4096 - 156, portrait.cx, 1e-9)
        assertEquals(648 to 720, portrait.width to portrait.height)
    }

    private companion object {
        val POINTS = listOf(Vector3(0.3, -0.2, 1.0), Vector3(-0.6, 0.5, 1.2))
    }
}
