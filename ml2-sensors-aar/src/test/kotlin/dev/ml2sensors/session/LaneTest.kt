package dev.ml2sensors.session

import dev.ml2sensors.source.CountedBuffers
import dev.ml2sensors.source.ImageSample
import dev.ml2sensors.source.testImage
import dev.ml2sensors.wire.FrameHeader
import dev.ml2sensors.wire.FrameKind
import kotlinx.coroutines.CoroutineScope
import kotlinx.coroutines.CoroutineStart
import kotlinx.coroutines.Dispatchers
import kotlinx.coroutines.async
import kotlinx.coroutines.cancelAndJoin
import kotlinx.coroutines.launch
import kotlinx.coroutines.runBlocking
import org.junit.jupiter.api.AfterEach
import org.junit.jupiter.api.Test
import java.io.IOException
import java.nio.ByteBuffer
import kotlin.random.Random
import kotlin.test.assertEquals
import kotlin.test.assertFailsWith
import kotlin.test.assertFalse
import kotlin.test.assertNotNull

class LaneTest {
    private val counters = ChannelCounters()
    private val pool = CountedBuffers(bufferBytes = 4)
    private val kernel = FakeKernel()
    private val lane = Lane("test", laneClass(4), suspendsWhenFull = false)
    private val waitingLane = Lane("test", laneClass(4), suspendsWhenFull = true)

    @AfterEach
    fun everythingIsCountedAndGivenBack() {
        val counts = counters.snapshot()
        assertEquals(counts.produced, counts.sent + counts.dropped.values.sum())
        assertEquals(0, pool.outstanding)
    }

    @Test
    fun framesWithoutASessionAreDroppedAsLinkDown() = runBlocking<Unit> {
        repeat(3) { lane.offer(frame()) }
        assertEquals(mapOf("link_down" to 3L), counters.snapshot().dropped)
    }

    @Test
    fun framesAreSentInOrder() = runBlocking<Unit> {
        val sender = send(lane)
        kernel.open(10)
        repeat(10) {
            lane.offer(frame())
            kernel.awaitWrites(it + 1)
        }
        lane.finish()
        sender.join()
        assertEquals((0..9).toList(), kernel.sequences)
        assertEquals(10, counters.snapshot().sent)
    }

    @Test
    fun smallFramesThatWaitAreWrittenTogetherAndImagesAlone() = runBlocking<Unit> {
        writeBehindASmallFrame(writes = 4) { long ->
            repeat(3) { long.offer(smallFrame(8)) }
            long.offer(frame())
            repeat(2) { long.offer(smallFrame(8)) }
        }
        assertEquals(listOf(listOf(0), listOf(1, 2, 3), listOf(4), listOf(5, 6)), kernel.writes)
        assertEquals(7, counters.snapshot().sent)
    }

    /** Offers frames while a small one is being written, and returns after [writes] writes. */
    private suspend fun CoroutineScope.writeBehindASmallFrame(writes: Int, offer: suspend (Lane) -> Unit) {
        val long = Lane("test", laneClass(64), suspendsWhenFull = false)
        val sender = send(long)
        long.offer(smallFrame(8))
        kernel.awaitEntered()
        offer(long)
        kernel.open(writes)
        long.finish()
        sender.join()
    }

    @Test
    fun noMoreIsWrittenTogetherThanOneRecordOfTlsTakes() = runBlocking<Unit> {
        writeBehindASmallFrame(writes = 5) { long ->
            repeat(9) { long.offer(smallFrame(4096 - FrameHeader.BYTES)) }
            long.offer(smallFrame(60_000))
        }
        assertEquals(listOf(listOf(0), (1..4).toList(), (5..8).toList(), listOf(9), listOf(10)), kernel.writes)
    }

    @Test
    fun aConnectionThatBreaksWhileSmallFramesAreWrittenTogetherCountsThemAndTheNext() = runBlocking<Unit> {
        val long = Lane("test", laneClass(64), suspendsWhenFull = false)
        val sender = async(Dispatchers.IO, CoroutineStart.UNDISPATCHED) {
            assertFailsWith<IOException> { long.sendThrough(kernel.writer()) }
        }
        long.offer(smallFrame(8))
        kernel.awaitEntered()
        repeat(3) { long.offer(smallFrame(8)) }
        long.offer(frame())
        kernel.open(1)
        kernel.awaitEntered()
        kernel.breakDown()
        sender.await()
        assertEquals(1, counters.snapshot().sent)
        assertEquals(mapOf("link_down" to 4L), counters.snapshot().dropped)
    }

    @Test
    fun aFullQueueDropsTheOldestThatIsNotUnderWay() = runBlocking<Unit> {
        val sender = send(lane)
        lane.offer(frame())
        kernel.awaitEntered()
        repeat(6) { lane.offer(frame()) }
        assertEquals(mapOf("queue_full" to 2L), counters.snapshot().dropped)
        assertEquals(5, pool.outstanding, "memory of what was dropped is free at once")
        kernel.open(5)
        lane.finish()
        sender.join()
        assertEquals(listOf(0, 3, 4, 5, 6), kernel.sequences)
    }

    @Test
    fun finishingSendsWhatIsQueued() = runBlocking<Unit> {
        val sender = send(lane)
        lane.offer(frame())
        kernel.awaitEntered()
        repeat(4) { lane.offer(frame()) }
        lane.finish()
        kernel.open(5)
        sender.join()
        assertEquals(5, counters.snapshot().sent)
    }

    @Test
    fun aBrokenConnectionCountsWhatWasUnderWayAndQueued() = runBlocking<Unit> {
        val sender = async(Dispatchers.IO, CoroutineStart.UNDISPATCHED) {
            assertFailsWith<IOException> { lane.sendThrough(kernel.writer()) }
        }
        lane.offer(frame())
        kernel.awaitEntered()
        repeat(4) { lane.offer(frame()) }
        kernel.breakDown()
        sender.await()
        lane.offer(frame())
        assertEquals(mapOf("link_down" to 6L), counters.snapshot().dropped)
    }

    @Test
    fun aLaneOutlivesItsConnections() = runBlocking<Unit> {
        repeat(3) {
            val sender = launch(Dispatchers.IO, CoroutineStart.UNDISPATCHED) {
                runCatching { lane.sendThrough(kernel.writer()) }
            }
            lane.offer(frame())
            kernel.awaitEntered()
            lane.offer(frame())
            kernel.open(1)
            kernel.awaitEntered() // now the first is counted
            sender.cancelAndJoin()
        }
        assertEquals(listOf(0, 2, 4), kernel.sequences)
        assertEquals(mapOf("link_down" to 3L), counters.snapshot().dropped)
    }

    @Test
    fun aLaneThatWaitsSuspendsItsProducersWhileItIsFull() = runBlocking<Unit> {
        val sender = send(waitingLane)
        val producer = launch(Dispatchers.Default) { repeat(50) { waitingLane.offer(frame()) } }
        kernel.awaitEntered()
        assertFalse(producer.isCompleted)
        kernel.open(50)
        producer.join()
        waitingLane.finish()
        sender.join()
        assertEquals((0..49).toList(), kernel.sequences)
        assertEquals(50, counters.snapshot().sent)
    }

    @Test
    fun aLaneThatWaitsSuspendsItsProducersWhileThereIsNoSession() = runBlocking<Unit> {
        val producer = launch(start = CoroutineStart.UNDISPATCHED) { waitingLane.offer(frame()) }
        assertFalse(producer.isCompleted)
        kernel.open(1)
        val sender = send(waitingLane)
        producer.join()
        waitingLane.finish()
        sender.join()
        assertEquals(1, counters.snapshot().sent)
    }

    @Test
    fun aProducerCancelledWhileItWaitsLosesNoFrameUncounted() = runBlocking<Unit> {
        val unlinked = launch(start = CoroutineStart.UNDISPATCHED) { waitingLane.offer(frame()) }
        unlinked.cancelAndJoin()
        assertEquals(mapOf("link_down" to 1L), counters.snapshot().dropped)
        val sender = send(waitingLane)
        waitingLane.offer(frame())
        kernel.awaitEntered()
        repeat(4) { waitingLane.offer(frame()) }
        val full = launch(start = CoroutineStart.UNDISPATCHED) { waitingLane.offer(frame()) }
        assertFalse(full.isCompleted)
        full.cancelAndJoin()
        kernel.open(5)
        waitingLane.finish()
        sender.join()
        assertEquals(5, counters.snapshot().sent)
    }

    @Test
    fun aLinkThatBreaksUnderManyProducersLeavesNoFrameUncounted() = runBlocking<Unit> {
        val random = Random(9)
        repeat(2_000) {
            val any = if (it % 2 == 0) lane else waitingLane
            val link = launch(Dispatchers.IO) { any.sendThrough(FakeKernel(open = true).writer()) }
            any.awaitSession()
            val producers = List(3) { launch(Dispatchers.Default) { repeat(10) { any.offer(frame()) } } }
            repeat(random.nextInt(2_000)) { Thread.onSpinWait() }
            link.cancelAndJoin()
            producers.forEach { producer -> producer.cancelAndJoin() }
            assertEquals(0, pool.outstanding)
        }
    }

    private fun CoroutineScope.send(lane: Lane) =
        launch(Dispatchers.IO, CoroutineStart.UNDISPATCHED) { lane.sendThrough(kernel.writer()) }

    private fun smallFrame(bodyBytes: Int): OutgoingFrame {
        val head = ByteBuffer.allocate(FrameHeader.BYTES + bodyBytes)
        FrameHeader(FrameKind.DATA.code, bodyBytes, 1, counters.nextSequence()).writeTo(head)
        return OutgoingFrame(counters, head.rewind(), data = null, sample = null)
    }

    private fun frame(): OutgoingFrame {
        val memory = pool.acquire()
        val planes = listOf(ImageSample.Plane(ImageSample.IMAGE, memory))
        val sample = testImage(width = 4, height = 1, planes) { pool.release(memory) }
        val head = ByteBuffer.allocate(FrameHeader.BYTES)
        FrameHeader(FrameKind.DATA.code, 4, 1, counters.nextSequence()).writeTo(head)
        return OutgoingFrame(counters, head.flip(), assertNotNull(sample.plane(ImageSample.IMAGE)), sample)
    }
}
