package dev.ml2sensors.wire

import org.junit.jupiter.api.Test
import java.io.EOFException
import java.io.IOException
import java.nio.ByteBuffer
import java.nio.channels.ReadableByteChannel
import kotlin.random.Random
import kotlin.test.assertContentEquals
import kotlin.test.assertEquals
import kotlin.test.assertFailsWith
import kotlin.test.assertIs
import kotlin.test.assertNotNull
import kotlin.test.assertNull
import kotlin.test.assertTrue

class FrameReaderTest {
    private val bye = frame(52, """{"reason": "over"}""".toByteArray())

    @Test
    fun endsInsideOfAFrameAreErrorsAtEveryOffset() {
        assertNull(FrameReader(Bytes(ByteArray(0))).next(ALL))
        for (length in 1 until bye.size) {
            assertFailsWith<EOFException>("at $length") { FrameReader(Bytes(bye.copyOf(length))).next(ALL) }
        }
    }

    @Test
    fun aLyingLengthCostsAChunkBeforeItsBytesArrive() {
        val claimed = 16 shl 20
        for (arriving in listOf(0, 1, 4096, 100_000)) {
            val source = Bytes(frame(16, ByteArray(claimed)).copyOf(FrameHeader.BYTES + arriving))
            assertFailsWith<EOFException> { FrameReader(source, LargeBuffers()).next(ALL) }
            assertTrue(source.largestTarget <= maxOf(4096, 2 * arriving), "${source.largestTarget} for $arriving")
        }
    }

    @Test
    fun largeBodiesArriveInABufferThatIsUsedAgain() {
        val buffers = LargeBuffers()
        val bodies = List(3) { Random(it).nextBytes(1 shl 20) }
        for ((body, count) in bodies.zip(listOf(9, 1, 1))) {
            val source = Bytes(frame(16, body))
            assertContentEquals(body, assertNotNull(FrameReader(source, buffers).next(ALL)).body)
            assertEquals(count, source.targets.size - 1)
        }
    }

    @Test
    fun aKindThatIsNotAllowedIsRefusedByItsHeaderAlone() {
        val header = frame(16, ByteArray(1 shl 20)).copyOf(FrameHeader.BYTES)
        val refusal = assertFailsWith<ProtocolException> { FrameReader(Bytes(header)).next(setOf(FrameKind.BYE)) }
        assertEquals(ErrorCode.UNEXPECTED, refusal.code)
    }

    @Test
    fun errorsAreAllowedEverywhere() {
        assertEquals(FrameKind.ERROR, assertNotNull(FrameReader(Bytes(frame(51))).next(emptySet())).kind)
    }

    @Test
    fun anyBytesAreFramesOrAnIoException() {
        val random = Random(7)
        repeat(2_000) {
            val bytes = bye + frame(random.nextInt(256), random.nextBytes(random.nextInt(40))) + bye
            repeat(random.nextInt(4)) { bytes[random.nextInt(bytes.size)] = random.nextInt().toByte() }
            val reader = FrameReader(Bytes(bytes, random.nextInt(1, 50)))
            runCatching { while (reader.next(ALL) != null) Unit }.onFailure { assertIs<IOException>(it) }
        }
    }

    private companion object {
        val ALL = FrameKind.entries.toSet()

        fun frame(kind: Int, body: ByteArray = ByteArray(0)): ByteArray {
            val frame = ByteBuffer.allocate(FrameHeader.BYTES + body.size)
            FrameHeader(kind, body.size).writeTo(frame)
            return frame.put(body).array()
        }
    }
}

/** A connection that delivers [bytes], at most [atOnce] at a time, and notes how much it was asked for. */
private class Bytes(bytes: ByteArray, private val atOnce: Int = Int.MAX_VALUE) : ReadableByteChannel {
    private val source = ByteBuffer.wrap(bytes)
    var largestTarget = 0
    val targets = HashSet<Int>()

    override fun read(target: ByteBuffer): Int {
        largestTarget = maxOf(largestTarget, target.capacity())
        targets += target.capacity()
        if (!source.hasRemaining()) return -1
        val count = minOf(atOnce, target.remaining(), source.remaining())
        target.put(source.slice().limit(count))
        source.position(source.position() + count)
        return count
    }

    override fun isOpen() = true

    override fun close() = Unit
}
