package dev.ml2sensors.wire

import dev.ml2sensors.cdr.hex
import dev.ml2sensors.pacing.ImagePacing
import org.junit.jupiter.api.Test
import java.io.IOException
import java.nio.ByteBuffer
import java.nio.channels.GatheringByteChannel
import kotlin.concurrent.thread
import kotlin.test.assertContentEquals
import kotlin.test.assertEquals
import kotlin.test.assertFailsWith
import kotlin.test.assertTrue

class FrameWriterTest {
    @Test
    fun controlFramesAreHeaderAndBody() {
        val target = Collected()
        FrameWriter(target) { 0x1122334455667788 }.write(FrameKind.BYE, "{}".toByteArray())
        val expected = hex(
            """
            4d 32 01 34              # magic, version, kind 52 BYE
            00 00 00 00 00 00 00 00  # flags, channel, sequence
            02 00 00 00              # length
            00 00 00 00 00 00 00 00  # capture
            88 77 66 55 44 33 22 11  # send
            7b 7d
            """,
        )
        assertContentEquals(expected, target.bytes())
    }

    @Test
    fun gatheringWritesResumeAfterShortOnes() {
        val tail = ByteArray(1000) { it.toByte() }
        for (atOnce in listOf(1, 3, 31, 32, 33, 35, 36, 999, 5000)) {
            val target = Collected(atOnce)
            val head = head(prefixBytes = 4, dataBytes = tail.size)
            val expected = head.array() + tail
            FrameWriter(target) { 0 }.write(head, ByteBuffer.wrap(tail))
            assertContentEquals(expected, target.bytes(), "$atOnce at once")
        }
    }

    @Test
    fun piecesAreWrittenFromPositionToLimit() {
        val target = Collected()
        val head = ByteBuffer.allocate(100).position(10)
        FrameHeader(FrameKind.DATA.code, 2).writeTo(head)
        head.limit(42).position(10)
        FrameWriter(target) { 5 }.write(head, ByteBuffer.wrap(byteArrayOf(1, 2, 3, 4), 1, 2))
        assertEquals(34, target.bytes().size)
        assertContentEquals(byteArrayOf(5, 0, 0, 0, 0, 0, 0, 0, 2, 3), target.bytes().copyOfRange(24, 34))
    }

    @Test
    fun anEmptyTailDoesNotLoseTheHead() {
        val target = Collected()
        FrameWriter(target) { 0 }.write(head(prefixBytes = 8, dataBytes = 0), ByteBuffer.allocate(0))
        assertEquals(FrameHeader.BYTES + 8, target.bytes().size)
    }

    @Test
    fun framesOfTwoThreadsDoNotMix() {
        val target = Collected(atOnce = 5)
        val writer = FrameWriter(target) { 0 }
        val writers = listOf(11, 22).map { fill ->
            thread {
                repeat(300) {
                    val body = ByteArray(30) { fill.toByte() }
                    writer.write(FrameKind.STATUS, body)
                    writer.write(head(prefixBytes = 0, dataBytes = 30), ByteBuffer.wrap(body))
                }
            }
        }
        writers.forEach(Thread::join)
        val bytes = ByteBuffer.wrap(target.bytes())
        repeat(1200) {
            val body = ByteArray(FrameHeader.read(bytes).length).also(bytes::get)
            assertEquals(1, body.distinct().size)
        }
        assertEquals(0, bytes.remaining())
    }

    @Test
    fun framesThatWereHandedOverBeforeAFailureAreTold() {
        val frames = List(4) { head(prefixBytes = 68, dataBytes = 0) }
        val target = Collected(atOnce = 50, room = 250)
        var written = 0
        assertFailsWith<IOException> { FrameWriter(target) { 0 }.writeTogether(frames) { written++ } }
        assertEquals(2, written, "of 100 bytes each")
    }

    /** In virtual time, in which a thread that waits lets time pass. */
    @Test
    fun allFramesOfAPacedLaneArePacedWithPixelsOrWithout() {
        var nanos = 0L
        val writer = FrameWriter(Collected(), ImagePacing({ nanos }, { nanos += it }) { false }) { 0 }
        val small = List(8) { head(prefixBytes = 15_900, dataBytes = 0) }
        val writes = mapOf(
            "pixels" to { writer.write(head(prefixBytes = 4, dataBytes = 128_000), ByteBuffer.allocate(128_000)) },
            "no pixels" to { writer.write(head(prefixBytes = 128_000, dataBytes = 0), null) },
            "small frames" to { small.forEach { writer.writeTogether(listOf(it)) {} } },
        )
        for ((name, write) in writes) {
            val began = nanos
            write()
            assertTrue((nanos - began) / 1e9 in 0.04..0.12, "$name: ${nanos - began} ns for 128 kB")
        }
        val began = nanos
        repeat(10) { writer.write(FrameKind.ERROR, ByteArray(4000)) }
        assertEquals(began, nanos, "control frames wait for nothing")
    }

    @Test
    fun bodiesAboveTheirBoundAreMisuse() {
        val writer = FrameWriter(Collected()) { 0 }
        assertFailsWith<IllegalArgumentException> { writer.write(FrameKind.PING, byteArrayOf(0)) }
        assertFailsWith<IllegalArgumentException> { writer.write(FrameKind.BYE, ByteArray(4097)) }
    }

    private fun head(prefixBytes: Int, dataBytes: Int): ByteBuffer {
        val head = ByteBuffer.allocate(FrameHeader.BYTES + prefixBytes)
        FrameHeader(FrameKind.DATA.code, prefixBytes + dataBytes, channel = 3, sequence = 4).writeTo(head)
        return head.rewind()
    }
}

/** A connection whose kernel takes at most [atOnce] bytes of each write, and fails after [room] bytes. */
private class Collected(private val atOnce: Int = Int.MAX_VALUE, private val room: Int = 1 shl 20) :
    GatheringByteChannel {
    private val target = ByteBuffer.allocate(1 shl 20)

    fun bytes(): ByteArray = target.array().copyOf(target.position())

    override fun write(sources: Array<out ByteBuffer>, offset: Int, length: Int): Long {
        if (target.position() >= room) throw IOException("broken")
        var left = atOnce
        for (source in sources.slice(offset until offset + length)) {
            val count = minOf(left, source.remaining())
            target.put(source.slice().limit(count))
            source.position(source.position() + count)
            left -= count
        }
        return (atOnce - left).toLong()
    }

    override fun write(sources: Array<out ByteBuffer>): Long = write(sources, 0, sources.size)

    override fun write(source: ByteBuffer): Int = write(arrayOf(source)).toInt()

    override fun isOpen() = true

    override fun close() = Unit
}
