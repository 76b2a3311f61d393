package dev.ml2sensors.simulator.testsignal

import dev.ml2sensors.message.OPTICAL_IN_BODY
import dev.ml2sensors.message.Vector3
import dev.ml2sensors.message.rotate
import dev.ml2sensors.message.times
import dev.ml2sensors.simulator.signal.Capture
import dev.ml2sensors.source.DropReason
import dev.ml2sensors.source.ImageSample
import dev.ml2sensors.source.LostSamples
import dev.ml2sensors.source.StreamValues
import org.junit.jupiter.api.Test
import java.nio.ByteBuffer
import java.nio.ByteOrder
import javax.imageio.ImageIO
import kotlin.math.abs
import kotlin.math.sqrt
import kotlin.test.assertContentEquals
import kotlin.test.assertEquals
import kotlin.test.assertFalse
import kotlin.test.assertIs
import kotlin.test.assertNotNull
import kotlin.test.assertTrue

class CamerasTest {
    private val depth = StreamValues(0, 544, 480, 5, "Depth32", confidence = true, flags = true)

    @Test
    fun depthIsZOfPointsOnSurfacesOfTheScene() {
        val (image) = depthCamera(depth).draw(0.3).map(::floats)
        val toScene = SENSOR_EXTRINSICS.getValue("depth").rotation * OPTICAL_IN_BODY.rotation
        for (pixel in image.indices step 101) {
            if (image[pixel].isNaN()) continue
            val ray = DEPTH_LENS.ray((pixel % 544).toDouble(), (pixel / 544).toDouble())
            val point = toScene.rotate(ray * image[pixel].toDouble())
            assertTrue(distanceToScene(point, Scene.spheres(0.3)) < 1e-5, "pixel $pixel sees $point")
        }
    }

    @Test
    fun radialDepthIsTheDistance() {
        val (z) = depthCamera(depth).draw(0.0).map(::floats)
        val (radial) = depthCamera(depth.copy(radial = true)).draw(0.0).map(::floats)
        for (pixel in z.indices step 37) {
            val ray = DEPTH_LENS.ray((pixel % 544).toDouble(), (pixel / 544).toDouble())
            if (!z[pixel].isNaN()) assertEquals(sqrt(ray dot ray) * z[pixel], radial[pixel].toDouble(), 1e-5)
        }
    }

    @Test
    fun shortRangeIsWithinItsRange() {
        val (near) = depthCamera(depth.copy(stream = 1)).draw(0.0).map(::floats)
        val (far) = depthCamera(depth).draw(0.0).map(::floats)
        assertTrue(near.all { it.isNaN() || it in 0.2f..1.2f })
        assertTrue(far.all { it.isNaN() || it in 0.5f..5f })
    }

    @Test
    fun invalidDepthIsNanAndFlaggedAndOfLowConfidenceOrAtAnEdge() {
        val (image, confidence, flags) = depthCamera(depth).draw(0.6).map(::floats)
        val bits = flags.map { it.toRawBits() }
        assertEquals(setOf(0, 0b01001, 0b10001), bits.toSet())
        assertTrue(image.indices.all { image[it].isNaN() == (bits[it] and 1 == 1) })
        assertTrue(image.indices.all { bits[it] != 0b01001 || confidence[it] < 12f })
        assertTrue(image.count { it.isNaN() } in 1..image.size / 10)
    }

    @Test
    fun planesThatAreNotRequestedAreAbsent() {
        assertEquals(setOf("image"), depthCamera(depth.copy(confidence = false, flags = null)).planes.keys)
        assertEquals(listOf("image", "flags"), depthCamera(depth.copy(confidence = null)).planes.keys.toList())
    }

    @Test
    fun everyCameraShowsMotionAndManyValues() {
        val cameras = listOf(
            worldCamera("world_left", isLowExposure = false),
            eyeCamera("eye_nasal_left"),
            colorCamera("color", 640, 480, isMixed = false),
            colorCamera("mixed_reality", 648, 720, isMixed = true),
            infraredCamera(StreamValues(1, 544, 480, 30, "DepthRaw")),
        )
        for (camera in cameras) {
            val (first) = camera.draw(0.0)
            val (later) = camera.draw(0.25)
            assertFalse(first.contentEquals(later))
            assertContentEquals(first, camera.draw(0.0).single())
            assertTrue(first.toSet().size > 50)
        }
    }

    @Test
    fun lowExposureIsDarkerAndReportsAShorterExposure() {
        val normal = worldCamera("world_left", isLowExposure = false)
        val low = worldCamera("world_left", isLowExposure = true)
        assertTrue(4 * brightness(low.draw(0.0).single()) < brightness(normal.draw(0.0).single()))
        assertTrue(checkNotNull(low.settings.exposureNanos) < checkNotNull(normal.settings.exposureNanos))
    }

    @Test
    fun colorImagesAreJpegsOfTheirSize() {
        val image = ImageIO.read(colorCamera("color", 1280, 720, isMixed = false).draw(0.0).single().inputStream())
        assertEquals(1280 to 720, image.width to image.height)
    }

    @Test
    fun aCaptureIsLostIfOneOfItsPlanesHasNoBuffer() {
        val planeLoops = listOf("image", "confidence").map {
            PlaneLoop(it, FrameNumber.FLOAT32, listOf(ByteArray(128)))
        }
        val signal = FrameLoop(depthCamera(depth), planeLoops).signal(rateHz = 5, Trajectory(1))
        repeat(7) { assertNotNull(planeLoops[1].lease(0)) }
        val sample = assertIs<ImageSample>(signal.read(Capture(0, 0, 0.0)))
        val lost = assertIs<LostSamples>(signal.read(Capture(1, 200_000_000, 0.2)))
        assertEquals(DropReason.NO_BUFFER, lost.reason)
        sample.release()
        repeat(8) { assertNotNull(planeLoops[0].lease(0)) }
    }

    private fun brightness(image: ByteArray) = image.sumOf { it.toInt() and 255 }

    private fun floats(image: ByteArray): FloatArray {
        val pixels = ByteBuffer.wrap(image).order(ByteOrder.LITTLE_ENDIAN).asFloatBuffer()
        return FloatArray(pixels.remaining()).also { pixels.get(it) }
    }

    private fun distanceToScene(point: Vector3, spheres: List<Sphere>): Double {
        val walls = listOf(
            Scene.HALF_LENGTH - abs(point.x),
            Scene.HALF_WIDTH - abs(point.y),
            Scene.HALF_HEIGHT - abs(point.z),
        )
        val surfaces = spheres.map { sphere -> (point - sphere.center).let { sqrt(it dot it) } - sphere.radius }
        return (walls + surfaces).minOf { abs(it) }
    }
}
