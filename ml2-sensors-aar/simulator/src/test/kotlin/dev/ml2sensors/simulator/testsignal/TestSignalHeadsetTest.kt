package dev.ml2sensors.simulator.testsignal

import dev.ml2sensors.message.OPTICAL_IN_BODY
import dev.ml2sensors.message.Transform
import dev.ml2sensors.message.times
import dev.ml2sensors.simulator.signal.clock
import dev.ml2sensors.source.Answer
import dev.ml2sensors.source.DropReason
import dev.ml2sensors.source.ImageSample
import dev.ml2sensors.source.InputSample
import dev.ml2sensors.source.LostSamples
import dev.ml2sensors.source.PoseSample
import dev.ml2sensors.source.PosesSample
import dev.ml2sensors.source.Sample
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable
import kotlinx.coroutines.async
import kotlinx.coroutines.flow.collect
import kotlinx.coroutines.flow.first
import kotlinx.coroutines.flow.map
import kotlinx.coroutines.flow.take
import kotlinx.coroutines.flow.toList
import kotlinx.coroutines.launch
import kotlinx.coroutines.test.TestScope
import kotlinx.coroutines.test.runTest
import org.junit.jupiter.api.Test
import kotlin.test.assertEquals
import kotlin.test.assertFailsWith
import kotlin.test.assertIs
import kotlin.test.assertNotNull
import kotlin.test.assertNull
import kotlin.test.assertTrue

class TestSignalHeadsetTest {
    @Test
    fun everySensorOfTheStreamTableDeliversSamples() = withHeadset { headset ->
        for (stream in StreamTable.all - DERIVED.toSet()) {
            val sample = headset.samples(stream, headset.accepted(stream)).first()
            assertTrue(sample.captureNanos <= headset.clock.nowNanos())
        }
    }

    @Test
    fun derivedStreamsAreNotSensors() = withHeadset { headset ->
        for (stream in DERIVED) {
            assertFailsWith<IllegalArgumentException> { headset.samples(stream, StreamValues()) }
        }
    }

    @Test
    fun sensorsOfEqualRateCaptureAtTheSameTimesAndImagesShowTheirNumber() = withHeadset { headset ->
        val streams = listOf(StreamTable.eyeNasalLeft, StreamTable.eyeTempleRight, StreamTable.worldCenter)
        headset.render(streams)
        val captures = streams.map { stream ->
            async {
                val captures = mutableListOf<Pair<Long, Long>>()
                headset.samples(stream, headset.accepted(stream)).take(40).collect {
                    val image = it as ImageSample
                    assertEquals(image.frameNumber, image.shownNumber())
                    captures += image.frameNumber to image.captureNanos
                }
                captures
            }
        }.map { it.await() }
        assertEquals((0L until 40).toList(), captures[0].map { it.first })
        assertEquals(captures[0], captures[1])
        assertEquals(captures[0], captures[2])
    }

    @Test
    fun imagePoseIsHeadPoseTimesExtrinsicsAndEyeImagesHaveNone() = withHeadset { headset ->
        headset.render(listOf(StreamTable.worldLeft))
        val world = async { headset.images(StreamTable.worldLeft, 20) { it.captureNanos to assertNotNull(it.pose) } }
        val poses = headset.samples(StreamTable.headPose, StreamValues()).take(40).toList()
        val heads = poses.associate { it.captureNanos to assertNotNull((it as PoseSample).pose) }
        for ((nanos, pose) in world.await()) {
            val expected = heads.getValue(nanos) * SENSOR_EXTRINSICS.getValue("world_left") * OPTICAL_IN_BODY
            assertNear(expected.translation, pose.translation, 1e-12)
            assertEquals(0.0, angleBetween(expected.rotation, pose.rotation), 1e-7)
        }
        headset.images(StreamTable.eyeNasalLeft, 1) {
            assertNull(it.pose)
            assertNull(it.intrinsics)
        }
    }

    @Test
    fun retainedImagesMakeLaterCapturesLost() = withHeadset { headset ->
        val kept = mutableListOf<ImageSample>()
        val samples = mutableListOf<Sample>()
        headset.samples(StreamTable.eyeNasalLeft, headset.accepted(StreamTable.eyeNasalLeft)).take(12).collect {
            samples += it
            if (it is ImageSample && kept.size < 8) kept += it.apply { retain() }
            if (samples.size == 10) kept.forEach(ImageSample::release)
        }
        val lost = samples.filterIsInstance<LostSamples>()
        assertEquals(listOf(1, 1), lost.map { it.count })
        assertEquals(setOf(DropReason.NO_BUFFER), lost.map { it.reason }.toSet())
        assertEquals(samples.slice(8..9), lost)
        assertEquals(listOf(0L..7L, 10L..11L).flatten(), samples.filterIsInstance<ImageSample>().map { it.frameNumber })
    }

    @Test
    fun anImageIsReleasedWhenTheCollectorReturns() = withHeadset { headset ->
        val image = headset.samples(StreamTable.eyeNasalLeft, headset.accepted(StreamTable.eyeNasalLeft)).first()
        assertFailsWith<IllegalStateException> { (image as ImageSample).pixels }
    }

    @Test
    fun closingEndsEveryFlow() = runTest {
        val headset = TestSignalHeadset(1, clock)
        val collecting = listOf(StreamTable.battery, StreamTable.eyeNasalLeft).map { stream ->
            val first = headset.samples(stream, headset.accepted(stream))
            first.first()
            launch { first.collect() }
        }
        val world = headset.samples(StreamTable.worldLeft, headset.accepted(StreamTable.worldLeft))
        val drawing = launch { world.collect() }
        testScheduler.runCurrent()
        headset.close()
        (collecting + drawing).forEach { it.join() }
        assertTrue((collecting + drawing).none { it.isCancelled })
    }

    @Test
    fun aHandIsEitherUntrackedOrHas26Joints() = withHeadset { headset ->
        val hands = headset.samples(StreamTable.handRight, StreamValues()).take(300).toList()
        val joints = hands.map { (it as PosesSample).poses }
        assertEquals(setOf(26), joints.map { it.size }.toSet())
        assertEquals(setOf(0, 26), joints.map { hand -> hand.count { it == PosesSample.UNTRACKED } }.toSet())
    }

    @Test
    fun everyButtonAndAxisOfTheControllerChangesWithinItsRange() = withHeadset { headset ->
        val samples = headset.samples(StreamTable.controllerJoy, StreamValues())
        val inputs = samples.take(300).toList().filterIsInstance<InputSample>()
        for (axis in listOf(InputSample::touchX, InputSample::touchY)) {
            val values = inputs.map(axis)
            assertTrue(values.min() in -1f..-0.4f && values.max() in 0.4f..1f, "$axis")
        }
        assertTrue(inputs.minOf { it.trigger } in 0f..0.1f && inputs.maxOf { it.trigger } in 0.9f..1f)
        for (button in listOf(InputSample::bumper, InputSample::menu)) {
            assertEquals(setOf(false, true), inputs.map(button).toSet(), "$button")
        }
    }

    @Test
    fun equalSeedsGiveEqualPoses() = runTest {
        suspend fun poses(seed: Long): List<Transform?> = TestSignalHeadset(seed, clock).use { headset ->
            headset.samples(StreamTable.gaze, StreamValues()).take(5).toList().map { (it as PoseSample).pose }
        }
        assertEquals(poses(5), poses(5))
        assertTrue(poses(5) != poses(6))
    }

    private fun withHeadset(test: suspend TestScope.(TestSignalHeadset) -> Unit) = runTest {
        TestSignalHeadset(seed = 1, clock).use { test(it) }
    }

    /** Renders all frames first: rendering takes real time, during which virtual time would advance. */
    private suspend fun TestSignalHeadset.render(streams: List<StreamSpec>) {
        for (stream in streams) samples(stream, accepted(stream)).first()
    }

    private suspend fun <T> TestSignalHeadset.images(stream: StreamSpec, count: Int, read: (ImageSample) -> T) =
        samples(stream, accepted(stream)).take(count).map { read(it as ImageSample) }.toList()

    private fun TestSignalHeadset.accepted(stream: StreamSpec): StreamValues {
        val mode = stream.modes.firstOrNull() ?: return StreamValues()
        val (width, height) = mode.resolutions.first()
        val values = StreamValues(mode.stream, width, height, mode.rates.first(), mode.formats.first())
        return assertIs<Answer.Applied>(negotiate(stream, values)).values
    }

    private fun ImageSample.shownNumber(): Long {
        val pixels = pixels
        return (0 until 32).fold(0L) { number, pixel -> 2 * number + if (pixels.get(pixel).toInt() == -1) 1 else 0 }
    }

    private companion object {
        val DERIVED =
            StreamTable.all.filter { it.id.startsWith("imu_") } + StreamTable.tf + StreamTable.custom
    }
}
