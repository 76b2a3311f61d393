package dev.ml2sensors.simulator.simulated

import dev.ml2sensors.simulator.SimulatedHeadset
import dev.ml2sensors.source.Answer
import dev.ml2sensors.source.DropReason
import dev.ml2sensors.source.ImageSample
import dev.ml2sensors.source.LostSamples
import dev.ml2sensors.source.Sample
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.source.VectorSample
import dev.ml2sensors.source.defaultValues
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable
import kotlinx.coroutines.CoroutineScope
import kotlinx.coroutines.asCoroutineDispatcher
import kotlinx.coroutines.flow.collect
import kotlinx.coroutines.flow.onEach
import kotlinx.coroutines.flow.take
import kotlinx.coroutines.flow.toList
import kotlinx.coroutines.launch
import kotlinx.coroutines.runBlocking
import java.nio.file.Path
import java.util.concurrent.Executor
import java.util.concurrent.LinkedBlockingQueue
import kotlin.io.path.absolute
import kotlin.io.path.createDirectories
import kotlin.math.sqrt
import kotlin.test.Test
import kotlin.test.assertContains
import kotlin.test.assertEquals
import kotlin.test.assertFailsWith
import kotlin.test.assertIs
import kotlin.test.assertNotNull
import kotlin.test.assertTrue

class SimulatedHeadsetTest {
    private fun samples(stream: StreamSpec, values: StreamValues, count: Int, late: (Int) -> Unit = {}): List<Sample> {
        assertIs<Answer.Applied>(headset.negotiate(stream, values))
        var index = 0
        return runBlocking { headset.samples(stream, values).onEach { late(index++) }.take(count).toList() }
    }

    @Test
    fun colourFramesComeInOrderAndMissedFramesAreCounted() {
        // A loss comes before the image that shows it, which the first and the last of eight samples may lack.
        val found = samples(StreamTable.color, COLOR, count = 8) { if (it == 1) Thread.sleep(LATE_MILLIS) }
            .dropWhile { it !is ImageSample }.dropLastWhile { it !is ImageSample }
        val lost = found.filterIsInstance<LostSamples>()
        assertEquals(setOf(DropReason.SOURCE_LATE), lost.map { it.reason }.toSet())
        val numbers = found.filterIsInstance<ImageSample>().map { it.frameNumber }
        assertEquals(numbers.first() + numbers.size - 1 + lost.sumOf { it.count }, numbers.last())
        assertEquals(numbers.sorted().distinct(), numbers)
    }

    @Test
    fun aColourCameraThatIsClosedWhileItOpensCanBeOpenedAgain() {
        val steps = LinkedBlockingQueue<Runnable>()
        val frames = CoroutineScope(Executor(steps::put).asCoroutineDispatcher()).launch {
            headset.samples(StreamTable.color, COLOR).collect()
        }
        steps.take().run()
        val opened = steps.take()
        frames.cancel()
        opened.run()
        while (!frames.isCompleted) steps.take().run()
        assertEquals(1, samples(StreamTable.color, COLOR, count = 1).size)
    }

    @Test
    fun aFactThatDoesNotHoldRefusesTheStreamsConcernedAlone() {
        headset.set("assume.sensor_names", "IMU")
        try {
            val answer = headset.negotiate(StreamTable.accelLeft, StreamTable.accelLeft.defaultValues())
            assertContains(assertIs<Answer.Refused>(answer).reason, "it lists: IMU")
            assertIs<Answer.Applied>(headset.negotiate(StreamTable.color, COLOR))
        } finally {
            headset.set("assume.sensor_names", "")
        }
        assertIs<Answer.Applied>(headset.negotiate(StreamTable.accelLeft, StreamTable.accelLeft.defaultValues()))
    }

    @Test
    fun colourFramesHaveTheirPoseAndIntrinsics() {
        val beginNanos = headset.clock.nowNanos()
        // Tracking needs some frames to begin
        val arrivals = mutableListOf<Long>()
        val found = samples(StreamTable.color, COLOR, count = 20) { arrivals += headset.clock.nowNanos() }
        val frames = found.filterIsInstance<ImageSample>()
        val frame = frames.first { it.pose != null }
        // The device forgets older poses.
        val fresh = found.filterIndexed { index, it -> arrivals[index] - it.captureNanos < 500_000_000 }
        val later = fresh.filterIsInstance<ImageSample>().filter { it.captureNanos >= frame.captureNanos }
        assertTrue(later.all { it.pose != null })
        assertEquals(WIDTH to HEIGHT, assertNotNull(frame.intrinsics).let { it.width to it.height })
        assertTrue(frames.last().captureNanos in beginNanos..headset.clock.nowNanos())
    }

    @Test
    fun accelerometersMeasureGravityOnASteady200HzGrid() {
        val found = samples(StreamTable.accelLeft, StreamValues(), count = 400)
        val readings = found.filterIsInstance<VectorSample>()
        assertEquals(setOf(0L), readings.map { it.captureNanos % 5_000_000 }.toSet())
        // On a busy machine samples may be lost, but each loss must be counted
        val lost = found.filterIsInstance<LostSamples>().associate { it.captureNanos to it.count }
        for ((a, b) in readings.zipWithNext()) {
            val next = a.captureNanos + 5_000_000
            assertEquals(next + 5_000_000L * (lost[next] ?: 0), b.captureNanos)
        }
        val mean = readings.map { sqrt(it.x * it.x + it.y * it.y + it.z * it.z) }.average()
        // The mean over the whole trajectory; single samples include the head's own acceleration
        assertEquals(9.81, mean, absoluteTolerance = 1.0)
    }

    @Test
    fun everyStreamOfTheTableHasASource() {
        val composed = StreamTable.all.filter { it.id.startsWith("imu_") } + StreamTable.tf + StreamTable.custom
        for (stream in (StreamTable.all - composed.toSet()).filter { it.modes.isEmpty() }) {
            assertIs<Answer.Applied>(headset.negotiate(stream, StreamValues()), stream.id)
        }
    }

    @Test
    fun aWrongSettingIsRefusedWithTheAllowedRange() {
        val failure = assertFailsWith<IllegalArgumentException> { headset.set("tangential", "much") }
        assertContains(failure.message.orEmpty(), """tangential: expected a number from -0.01 to 0.01, found "much"""")
    }

    private companion object {
        const val WIDTH = 640
        const val HEIGHT = 480

        /** Longer than a frame waits for a late collector. */
        const val LATE_MILLIS = 600L
        val COLOR = StreamValues(0, WIDTH, HEIGHT, 15, "jpeg")
        val cache = Path.of("target/frame_cache").createDirectories().absolute()
        val headset = SimulatedHeadset.open(settings = mapOf("cache" to "$cache", "loop_seconds" to "2"))
    }
}
