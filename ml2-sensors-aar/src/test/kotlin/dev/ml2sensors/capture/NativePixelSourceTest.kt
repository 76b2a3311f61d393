package dev.ml2sensors.capture

import dev.ml2sensors.message.Vector3
import dev.ml2sensors.message.rotate
import dev.ml2sensors.source.Distortion
import dev.ml2sensors.source.DropReason
import dev.ml2sensors.source.ImageSample
import dev.ml2sensors.source.LostSamples
import dev.ml2sensors.source.testImage
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable
import kotlinx.coroutines.flow.first
import kotlinx.coroutines.flow.take
import kotlinx.coroutines.flow.toList
import kotlinx.coroutines.runBlocking
import org.junit.jupiter.api.AfterEach
import org.junit.jupiter.api.Test
import java.nio.ByteBuffer
import java.nio.file.Path
import kotlin.io.path.listDirectoryEntries
import kotlin.io.path.readBytes
import kotlin.math.hypot
import kotlin.test.assertEquals
import kotlin.test.assertFailsWith
import kotlin.test.assertNotNull
import kotlin.test.assertNull
import kotlin.test.assertTrue

/** Tests the samples that the shipped library delivers of the simulated device, stream by stream. */
class NativePixelSourceTest {
    private val fixture = CaptureFixture()

    @AfterEach
    fun close(): Unit = fixture.close()

    @Test
    fun imagesHaveTheSizeOfTheirModeWithoutTheDevicesPadding() = runBlocking<Unit> {
        for (stream in CAMERAS) {
            val values = CaptureFixture.values(stream)
            val pixelBytes = if (stream in DEPTH_CAMERA) 4 else 1
            val beginNanos = Native.now()
            fixture.image(stream) {
                assertEquals(values.width to values.height, it.width to it.height, "$stream")
                assertEquals(it.width * pixelBytes, it.strideBytes, "$stream")
                assertEquals(it.width * it.height * pixelBytes, it.pixels.remaining(), "$stream")
                val expected = beginNanos - 500_000_000..Native.now()
                assertTrue(it.captureNanos in expected, "$stream captured at ${it.captureNanos}")
            }
        }
    }

    @Test
    fun pixelsAreThoseOfTheDevice() = runBlocking<Unit> {
        for (stream in listOf(StreamTable.worldRight, StreamTable.eyeNasalLeft)) {
            val image = fixture.image(stream) { it.copy() }
            assertTrue(frames(stream, image.size).any { it == ByteBuffer.wrap(image) }, "$stream shows another picture")
        }
    }

    @Test
    fun camerasAreWhereTheyTrulyWere() = runBlocking<Unit> {
        val cameras = listOf(StreamTable.worldLeft, StreamTable.worldRight, StreamTable.worldCenter, StreamTable.depth)
        for ((number, stream) in cameras.withIndex()) {
            val (found, truth) = fixture.image(stream) { it.pose to Simulation.truth(number, it.captureNanos) }
            // RUB to ROS, one axis at a time: the camera looks along -z and its image goes down along -y
            val forward = truth.rotation.rotate(Vector3(0.0, 0.0, -1.0)).toRos()
            val down = truth.rotation.rotate(Vector3(0.0, -1.0, 0.0)).toRos()
            val pose = assertNotNull(found, "$stream")
            assertNear(truth.position.toRos(), pose.translation)
            assertNear(forward, pose.rotation.rotate(Vector3(0.0, 0.0, 1.0)))
            assertNear(down, pose.rotation.rotate(Vector3(0.0, 1.0, 0.0)))
        }
    }

    @Test
    fun theColorCameraIsLocatedForImagesOfOthers() {
        assertNotNull(NativeColorPoses.open()).use { tracker ->
            var deviceNanos = 0L
            // Tracking takes a moment to begin, and the device forgets an instant soon
            val pose = generateSequence {
                deviceNanos = Simulation.mlTime(Native.now())
                deviceNanos
            }.firstNotNullOf(tracker::poseAt)
            assertNear(Simulation.truth(COLOR, tracker.captureNanos(deviceNanos)).position.toRos(), pose.translation)
            assertNull(tracker.poseAt(deviceNanos - 60_000_000_000))
        }
    }

    @Test
    fun lensesAreThoseOfTheDevice() = runBlocking<Unit> {
        val world = assertNotNull(fixture.image(StreamTable.worldCenter) { it.intrinsics })
        assertEquals(Distortion.FisheyeTangential(0.012, -0.006, 0.002, -0.0004, 1e-4, 1e-4), world.distortion)
        assertEquals(listOf(582f, 581.4f, 506.3f, 509.8f), world.run { listOf(fx, fy, cx, cy).map { it.toFloat() } })
        val depth = assertNotNull(fixture.image(StreamTable.depth) { it.intrinsics })
        assertEquals(Distortion.PlumbBob(-0.03, 0.01, 2e-4, -3e-4, -0.001), depth.distortion)
        assertEquals(544 to 480, depth.width to depth.height)
    }

    @Test
    fun eyeCamerasHaveNeitherPoseNorLens() = runBlocking<Unit> {
        for (stream in CAMERAS.filter { it.id.startsWith("eye") }) {
            fixture.image(stream) {
                assertNull(it.pose)
                assertNull(it.intrinsics)
            }
        }
    }

    @Test
    fun depthComesWithThePlanesThatWereAskedFor() = runBlocking<Unit> {
        val values = CaptureFixture.SHORT_RANGE
        fixture.image(StreamTable.depth, values) { assertNull(it.plane("confidence") ?: it.plane("flags")) }
        fixture.image(StreamTable.depth, values.copy(confidence = true, flags = true)) {
            val depth = it.pixels.asFloatBuffer()
            val flags = assertNotNull(it.plane("flags")).asIntBuffer()
            assertEquals(544 * 480, assertNotNull(it.plane("confidence")).asFloatBuffer().remaining())
            val valid = (0 until depth.limit()).count { pixel -> flags[pixel] == 0 }
            assertTrue(valid > 1000, "only $valid pixels are valid")
            for (pixel in 0 until depth.limit()) assertEquals(flags[pixel] == 0, depth[pixel].isFinite(), "at $pixel")
        }
    }

    @Test
    fun infraredCountsAreNumbers() = runBlocking<Unit> {
        fixture.image(StreamTable.infra) {
            val counts = it.pixels.asFloatBuffer()
            assertTrue((0 until counts.limit()).all { pixel -> counts[pixel].isFinite() && counts[pixel] >= 0 })
        }
    }

    @Test
    fun lowExposureIsAnotherStreamOfTheSameCamera() = runBlocking<Unit> {
        Simulation.configure("controller_tracked", 1)
        val low = CaptureFixture.values(StreamTable.worldLeft).copy(stream = 1)
        fun ImageSample.brightness() = copy().sumOf { it.toInt() and 255 } / (width * height)
        val normal = fixture.image(StreamTable.worldLeft) { it.brightness() }
        val dark = fixture.image(StreamTable.worldLeft, low) { it.brightness() }
        assertTrue(dark < normal, "low exposure shows $dark, normal $normal")
    }

    @Test
    fun aSampleIsNotReadAfterItsCollectorReturned() = runBlocking<Unit> {
        val kept = fixture.image(StreamTable.eyeNasalRight) { it }
        assertFailsWith<IllegalStateException> { kept.pixels }
        assertFailsWith<IllegalStateException> { kept.release() }
    }

    @Test
    fun aPoseOfAllZerosCostsTheImageItsPoseOnly() = runBlocking<Unit> {
        Simulation.configure("fault.pose.unusable", 1)
        val poses = fixture.images(StreamTable.worldLeft) { it.pose }.take(5).toList()
        assertEquals(List(5) { null }, poses)
    }

    @Test
    fun oddFramesAreCountedAsUnusableAndTheCameraGoesOn() = runBlocking<Unit> {
        Simulation.configure("fault.eye.odd_every", 2)
        var produced = 0
        var unusable = 0
        fixture.samples(StreamTable.eyeNasalLeft).first { sample ->
            when (sample) {
                is ImageSample -> produced++
                is LostSamples -> if (sample.reason == DropReason.UNUSABLE) unusable += sample.count
                else -> error("an eye camera delivered $sample")
            }
            produced >= 40
        }
        assertTrue(unusable >= 10, "$unusable unusable frames beside $produced images")
    }

    @Test
    fun aRunOfOddFramesEndsTheFlowAndSaysWhy() = runBlocking<Unit> {
        Simulation.configure("fault.eye.null_data", 1)
        val lost = ArrayList<LostSamples>()
        val failure = assertFailsWith<CaptureException.VendorFailure> {
            fixture.samples(StreamTable.eyeNasalLeft).collect { lost += it as LostSamples }
        }
        assertEquals(
            "30 captures in a row without a usable frame, the last: eye camera: empty picture of 400x400",
            failure.message,
        )
        assertEquals(30, lost.filter { it.reason == DropReason.UNUSABLE }.sumOf { it.count })
    }

    @Test
    fun whateverFailsOnTheWayEveryLeaseEnds() {
        val stream = StreamTable.eyeNasalLeft
        SlotPool(stream).use {
            for (failing in 0..2) {
                val frames = FrameBlock(3)
                repeat(3) { frames[it].place(stream.number, Native.take(stream.number, 64), 64) }
                repeat(3) { frames[it].fill(testImage(width = 8, height = 8)) }
                assertFailsWith<IllegalStateException> { frames.deliver(3) { index, _, _ -> check(index != failing) } }
                val leased = (0 until SlotPool.SLOTS).filter { runCatching { SlotPool.release(stream, it) }.isSuccess }
                assertEquals(emptyList(), leased, "leases that did not end when sample $failing failed")
            }
        }
    }

    @Test
    fun memoryIsThatOfTheModeInUse() = runBlocking<Unit> {
        val pictureBytes = 544L * 480 * 4
        fixture.image(StreamTable.depth) { assertAreSlotsOf(pictureBytes) }
        val allPlanes = CaptureFixture.SHORT_RANGE.copy(confidence = true, flags = true)
        fixture.image(StreamTable.depth, allPlanes) { assertAreSlotsOf(3 * pictureBytes) }
    }

    private fun assertAreSlotsOf(frameBytes: Long) {
        val mapped = Native.mappedBytes()
        assertEquals(0, mapped % frameBytes)
        assertTrue(mapped / frameBytes in 1L..SlotPool.SLOTS, "$mapped bytes for frames of $frameBytes")
    }

    /** The pictures that the simulated device drew for [stream], from its cache: [bytes] each, at whole pages. */
    private fun frames(stream: StreamSpec, bytes: Int): Sequence<ByteBuffer> {
        val files = Path.of("target/frame_cache").listDirectoryEntries("${stream.id}-*.frames")
        val pitch = (bytes + PAGE - 1) / PAGE * PAGE
        return files.asSequence().map { ByteBuffer.wrap(it.readBytes()) }.flatMap { cached ->
            (0 until cached.capacity() / pitch).asSequence().map { index ->
                cached.duplicate().position(index * pitch).limit(index * pitch + bytes)
            }
        }
    }

    private fun assertNear(expected: Vector3, found: Vector3) {
        val distance = hypot(hypot(expected.x - found.x, expected.y - found.y), expected.z - found.z)
        assertTrue(distance < 1e-4, "expected $expected, found $found")
    }

    private fun Vector3.toRos() = Vector3(-z, -x, y)

    private companion object {
        const val PAGE = 4096

        /** ML2SIM_COLOR */
        const val COLOR = 4
        val DEPTH_CAMERA = setOf(StreamTable.depth, StreamTable.infra)
        val CAMERAS = PixelSensor.entries.filter { it != PixelSensor.COLOR }.flatMap { it.streams }
    }
}
