package dev.ml2sensors.capture

import dev.ml2sensors.table.StreamTable
import org.junit.jupiter.api.AfterEach
import org.junit.jupiter.api.BeforeEach
import org.junit.jupiter.api.Test
import java.nio.ByteBuffer
import kotlin.concurrent.thread
import kotlin.test.assertEquals
import kotlin.test.assertFailsWith
import kotlin.test.assertIs

/** Misuse of the library is thrown back at the caller. */
class NativeTest {
    private val eyes = NativeSettings(PixelSensor.EYE.code, NativeBackend.SDK.code, PixelSensor.EYE.streams.bits())

    @BeforeEach
    fun begin(): Unit = Simulation.begin()

    @AfterEach
    fun end(): Unit = Simulation.assertIsLeftAsFound()

    @Test
    fun aDeadHandleIsAnIllegalState() {
        val handle = eyes.open()
        Native.close(handle)
        val frames = FrameBlock(4)
        assertFailsWith<IllegalStateException> { Native.poll(handle, 0, frames.memory) }
        assertFailsWith<IllegalStateException> { Native.pollReadings(handle, ReadingBlock(1).memory) }
        assertFailsWith<IllegalStateException> { Native.colorPose(handle, 0, ReadingBlock(1).memory) }
        assertFailsWith<IllegalStateException> { eyes.configure(handle) }
        assertFailsWith<IllegalStateException> { Native.close(handle) }
        assertFailsWith<IllegalStateException> { Native.close(0) }
    }

    @Test
    fun aHandleOfAnotherThreadIsAnIllegalState() {
        val handle = eyes.open()
        val failures = mutableListOf<Throwable?>()
        thread {
            failures += runCatching { Native.poll(handle, 0, FrameBlock(4).memory) }.exceptionOrNull()
            failures += runCatching { Native.close(handle) }.exceptionOrNull()
        }.join()
        Native.close(handle)
        assertEquals(2, failures.size)
        failures.forEach { assertIs<IllegalStateException>(it) }
    }

    @Test
    fun aSensorIsOpenOnce() {
        val handle = eyes.open()
        val refused = assertFailsWith<CaptureException.InUse> { eyes.open() }
        assertEquals("the sensor eye is open already: close it first", refused.message)
        Native.close(handle)
    }

    @Test
    fun memoryThatCCannotReachIsAnIllegalArgument() {
        val handle = eyes.open()
        assertFailsWith<IllegalArgumentException> { Native.poll(handle, 0, ByteBuffer.allocate(4096)) }
        assertFailsWith<IllegalArgumentException> { Native.poll(handle, 0, ByteBuffer.allocateDirect(8)) }
        Native.close(handle)
    }

    @Test
    fun whatIsNotLeasedCannotBeReleased() {
        val stream = StreamTable.eyeNasalLeft.number
        assertFailsWith<IllegalArgumentException> { Native.release(stream, 0) }
        assertFailsWith<IllegalArgumentException> { Native.release(stream, 99) }
        assertFailsWith<IllegalArgumentException> { Native.release(-1, 0) }
    }

    @Test
    fun slotsThatNobodyReservedAreAnIllegalArgument() {
        assertEquals(NativeFrame.NO_SLOT, Native.take(StreamTable.eyeNasalLeft.number, 64))
        assertFailsWith<IllegalArgumentException> { Native.take(StreamTable.eyeNasalLeft.number, 0) }
        assertFailsWith<IllegalArgumentException> { Native.retire(StreamTable.eyeNasalLeft.number) }
        assertFailsWith<IllegalArgumentException> { Native.bytes(StreamTable.eyeNasalLeft.number, 0, 0, 64) }
    }

    @Test
    fun aNameThatIsTooLongIsAnIllegalArgument() {
        assertFailsWith<IllegalArgumentException> { NativeLibrary.useOpenXr("x".repeat(512), context = null) }
    }
}
