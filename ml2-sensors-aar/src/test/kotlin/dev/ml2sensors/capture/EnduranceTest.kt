package dev.ml2sensors.capture

import com.sun.management.ThreadMXBean
import dev.ml2sensors.source.ImageSample
import kotlinx.coroutines.Dispatchers
import kotlinx.coroutines.cancelAndJoin
import kotlinx.coroutines.channels.Channel
import kotlinx.coroutines.delay
import kotlinx.coroutines.launch
import kotlinx.coroutines.runBlocking
import org.junit.jupiter.api.AfterEach
import org.junit.jupiter.api.Test
import java.lang.management.BufferPoolMXBean
import java.lang.management.ManagementFactory
import kotlin.test.assertTrue

/** Ten thousand frames, as fast as they can be had. */
class EnduranceTest {
    private val fixture = CaptureFixture()

    @AfterEach
    fun close(): Unit = fixture.close()

    @Test
    fun memoryDoesNotGrowWithTheFrames() = runBlocking<Unit> {
        Simulation.configure("clock", "manual")
        val images = Channel<Unit>(Channel.UNLIMITED)
        val streams = PixelSensor.EYE.streams.map { stream ->
            launch(Dispatchers.Default) { fixture.samples(stream).collect { if (it is ImageSample) images.send(Unit) } }
        }
        val time = launch(Dispatchers.Default) {
            while (true) {
                Simulation.advance(PERIOD_NANOS)
                delay(1)
            }
        }
        repeat(1_000) { images.receive() }
        val directBefore = directBytes()
        val allocatedBefore = allocatedBytes()
        repeat(10_000) { images.receive() }
        val perFrame = (allocatedBytes() - allocatedBefore) / 10_000
        val directAfter = directBytes()
        streams.forEach { it.cancelAndJoin() }
        time.cancelAndJoin() // last, for what waits for a frame waits in this time
        assertTrue(directAfter <= directBefore, "$directAfter bytes outside the heap after $directBefore")
        assertTrue(perFrame < FRAME_BYTES / 10, "$perFrame bytes were allocated per frame of $FRAME_BYTES")
    }

    private fun directBytes(): Long =
        ManagementFactory.getPlatformMXBeans(BufferPoolMXBean::class.java).single { it.name == "direct" }.memoryUsed

    /** By all threads since they began. */
    private fun allocatedBytes(): Long {
        val threads = ManagementFactory.getThreadMXBean() as ThreadMXBean
        return threads.getThreadAllocatedBytes(threads.allThreadIds).sum()
    }

    private companion object {
        const val PERIOD_NANOS = 1_000_000_000L / 30
        const val FRAME_BYTES = 400 * 400
    }
}
