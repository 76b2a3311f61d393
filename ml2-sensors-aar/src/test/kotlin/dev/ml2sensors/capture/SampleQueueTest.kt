package dev.ml2sensors.capture

import dev.ml2sensors.message.Transform
import dev.ml2sensors.source.DropReason
import dev.ml2sensors.source.ImageSample
import dev.ml2sensors.source.LostSamples
import dev.ml2sensors.source.PoseSample
import dev.ml2sensors.source.Sample
import dev.ml2sensors.source.testImage
import kotlinx.coroutines.CoroutineStart
import kotlinx.coroutines.channels.Channel
import kotlinx.coroutines.flow.flow
import kotlinx.coroutines.flow.take
import kotlinx.coroutines.flow.toList
import kotlinx.coroutines.launch
import kotlinx.coroutines.runBlocking
import org.junit.jupiter.api.Test
import kotlin.test.assertEquals
import kotlin.test.assertFailsWith

class SampleQueueTest {
    private val queue = SampleQueue(2)
    private val released = mutableListOf<Long>()

    @Test
    fun theOldestMakesRoomAndIsReportedBeforeTheNext() = runBlocking<Unit> {
        for (number in 1L..5L) queue.offer(image(number))
        queue.close(cause = null)
        assertEquals(listOf("3 source_late", "4", "5"), describe(samples()))
        assertEquals(listOf(1L, 2L, 3L, 4L, 5L), released)
    }

    @Test
    fun lossesThatMakeRoomAreStillCounted() = runBlocking<Unit> {
        repeat(3) { queue.offer(LostSamples(it.toLong(), 1, DropReason.NO_BUFFER)) }
        queue.offer(image(4))
        queue.close(cause = null)
        assertEquals(listOf("2 no_buffer", "1 no_buffer", "4"), describe(samples()))
    }

    @Test
    fun whatWaitsIsDeliveredBeforeTheFailure() = runBlocking<Unit> {
        queue.offer(image(1))
        queue.close(CaptureException.VendorFailure("it broke"))
        assertEquals(listOf("1"), deliveredUntilItBreaks())
        assertEquals(listOf(1L), released)
    }

    @Test
    fun lossesAfterTheLastSampleAreReportedBeforeTheEnd() = runBlocking<Unit> {
        queue.offer(image(1))
        queue.countLost(2, DropReason.UNUSABLE)
        queue.close(CaptureException.VendorFailure("it broke"))
        val received = deliveredUntilItBreaks { queue.countLost(3, DropReason.UNUSABLE) }
        assertEquals(listOf("2 unusable", "1", "3 unusable"), received)
    }

    @Test
    fun whatNobodyTakesIsReleasedOnce() = runBlocking<Unit> {
        queue.offer(image(1))
        queue.offer(image(2))
        flow { queue.deliverTo(this) }.take(1).toList()
        queue.offer(image(3))
        assertEquals(listOf(1L, 2L, 3L), released.sorted())
    }

    @Test
    fun aCollectorThatEndsAtTheReportOfALossLeavesNothing() = runBlocking<Unit> {
        queue.countLost(1, DropReason.NO_BUFFER)
        queue.offer(image(1))
        assertEquals(listOf("1 no_buffer"), describe(flow { queue.deliverTo(this) }.take(1).toList()))
        assertEquals(listOf(1L), released)
    }

    @Test
    fun aCollectorThatIsCancelledWhileItWaitsLeavesNothing() = runBlocking<Unit> {
        val collector = launch(start = CoroutineStart.UNDISPATCHED) { queue.deliverTo { } }
        queue.offer(image(1))
        collector.cancel()
        collector.join()
        queue.offer(image(2))
        assertEquals(listOf(1L, 2L), released.sorted())
    }

    @Test
    fun lossesAfterTheLastSampleAreReportedWithoutAnother() = runBlocking<Unit> {
        val reported = Channel<Sample>(Channel.UNLIMITED)
        val collector = launch(start = CoroutineStart.UNDISPATCHED) { queue.deliverTo(reported::send) }
        queue.countLost(2, DropReason.NO_BUFFER)
        assertEquals(listOf("2 no_buffer"), describe(listOf(reported.receive())))
        collector.cancel()
    }

    @Test
    fun lossesAreReportedBeforeTheEnd() = runBlocking<Unit> {
        queue.offer(image(1))
        queue.close(CaptureException.VendorFailure("it broke"))
        queue.countLost(3, DropReason.SOURCE_LATE)
        val received = deliveredUntilItBreaks { queue.countLost(2, DropReason.NO_BUFFER) }
        assertEquals(listOf("3 source_late", "1", "2 no_buffer"), received)
    }

    @Test
    fun aNewWorldWhoseFirstPoseWasDroppedIsToldByTheNext() = runBlocking<Unit> {
        val newWorlds = setOf(2L, 5L)
        for (nanos in 1L..4L) queue.offer(PoseSample(nanos, Transform.IDENTITY, isInNewWorld = nanos in newWorlds))
        val received = mutableListOf<Sample>()
        queue.deliverTo { sample ->
            received += sample
            if (sample.captureNanos == 3L && sample is PoseSample) {
                for (nanos in 5L..7L) queue.offer(PoseSample(nanos, null, isInNewWorld = nanos in newWorlds))
                queue.close(cause = null)
            }
        }
        val poses = received.filterIsInstance<PoseSample>().map { it.captureNanos to it.isInNewWorld }
        assertEquals(listOf(3L to true, 6L to true, 7L to false), poses)
    }

    /** Returns the samples before the failure "it broke"; [atImage] runs while an image is delivered. */
    private suspend fun deliveredUntilItBreaks(atImage: () -> Unit = {}): List<String> {
        val received = mutableListOf<Sample>()
        val failure = assertFailsWith<CaptureException.VendorFailure> {
            queue.deliverTo { sample ->
                received += sample
                if (sample is ImageSample) atImage()
            }
        }
        assertEquals("it broke", failure.message)
        return describe(received)
    }

    private suspend fun samples() = flow { queue.deliverTo(this) }.toList()

    private fun describe(samples: List<Sample>) = samples.map {
        if (it is LostSamples) "${it.count} ${it.reason.wireName}" else "${(it as ImageSample).frameNumber}"
    }

    private fun image(number: Long) =
        testImage(width = 0, height = 0, frameNumber = number, captureNanos = number) { released += number }
}
