package dev.ml2sensors.stream

import dev.ml2sensors.TEST_LIMIT
import dev.ml2sensors.source.defaultValues
import dev.ml2sensors.table.StreamTable
import dev.ml2sensors.wire.FrameHeader
import kotlinx.coroutines.delay
import kotlinx.coroutines.launch
import kotlinx.coroutines.runBlocking
import kotlinx.coroutines.test.StandardTestDispatcher
import kotlinx.coroutines.test.TestCoroutineScheduler
import kotlinx.coroutines.withTimeout
import org.junit.jupiter.api.Test
import java.nio.ByteBuffer
import java.nio.channels.GatheringByteChannel
import java.util.concurrent.CountDownLatch
import kotlin.test.assertEquals
import kotlin.test.assertTrue
import kotlin.time.Duration
import kotlin.time.Duration.Companion.milliseconds
import kotlin.time.Duration.Companion.seconds

class WarmUpTest {
    @Test
    fun messagesOfEveryTopicOfACameraAnInertialUnitAndTheHeadAreWritten() = runBlocking {
        val channels = HashSet<Int>()
        warmUp(WrittenTo { buffer -> channels += headers(buffer).map { it.channel } }, Duration.INFINITE)
        val outgoing = TopicChannels(suspendsWhenFull = false)
        val streams = listOf(StreamTable.worldLeft, StreamTable.color, StreamTable.imuLeft, StreamTable.tf)
        assertEquals(streams.flatMap { outgoing.of(it, it.defaultValues()) }.map { it.id }.toSet(), channels)
    }

    @Test
    fun itEndsAtItsLimitThoughNothingCanBeWritten() = runBlocking<Unit> {
        val begun = CountDownLatch(1)
        val never = CountDownLatch(1)
        val target = WrittenTo {
            begun.countDown()
            never.await()
        }
        val time = TestCoroutineScheduler()
        val warming = launch(StandardTestDispatcher(time)) { warmUp(target, limit = 1.seconds) }
        time.runUntil { begun.count == 0L }
        assertTrue(warming.isActive)
        time.advanceTimeBy(1.seconds)
        time.runUntil { warming.isCompleted }
    }

    /** Lets time stand still until [isSo], which other threads may bring about. */
    private suspend fun TestCoroutineScheduler.runUntil(isSo: () -> Boolean) = withTimeout(TEST_LIMIT) {
        while (!isSo()) {
            runCurrent()
            delay(1.milliseconds)
        }
    }
}

/** Reads the headers of the frames in [buffer]. The last frame may go on elsewhere. */
private fun headers(buffer: ByteBuffer): List<FrameHeader> = buildList {
    while (buffer.hasRemaining()) {
        val header = FrameHeader.read(buffer).also(::add)
        buffer.position((buffer.position() + header.length).coerceAtMost(buffer.limit()))
    }
}

/** Gives the first buffer of each write to [take]. */
private class WrittenTo(private val take: (ByteBuffer) -> Unit) : GatheringByteChannel {
    override fun write(source: ByteBuffer): Int {
        val size = source.remaining()
        take(source.duplicate())
        source.position(source.limit())
        return size
    }

    override fun write(sources: Array<out ByteBuffer>): Long {
        val rest = sources[1].remaining()
        sources[1].position(sources[1].limit())
        return write(sources[0]).toLong() + rest
    }

    override fun write(sources: Array<out ByteBuffer>, offset: Int, length: Int): Long = error("not called")

    override fun isOpen(): Boolean = true

    override fun close(): Unit = Unit
}
