package dev.ml2sensors.wire

import dev.ml2sensors.cdr.hex
import org.junit.jupiter.api.Test
import java.nio.ByteBuffer
import java.nio.ByteOrder
import kotlin.test.assertContentEquals
import kotlin.test.assertEquals
import kotlin.test.assertFailsWith
import kotlin.test.assertNull

class FrameHeaderTest {
    private val dataHeader = hex(
        """
        4d 32                    # magic "M2"
        01                       # version
        10                       # kind 16, DATA
        00 00                    # flags
        ff ff                    # channel 65535
        fe ff ff ff              # sequence 2^32 - 2
        00 00 00 01              # length 16 MiB
        15 cd 5b 07 00 00 00 80  # capture, the least i64 plus 123456789
        ff ff ff ff ff ff ff ff  # send -1
        """,
    )

    @Test
    fun headersAreThirtyTwoLittleEndianBytes() {
        val header = FrameHeader(16, 16 shl 20, 65535, -2, Long.MIN_VALUE + 123_456_789, -1)
        val target = ByteBuffer.allocate(FrameHeader.BYTES)
        header.writeTo(target)
        assertContentEquals(dataHeader, target.array())
        assertEquals(ByteOrder.BIG_ENDIAN, target.order(), "the buffer's order is its owner's")
    }

    @Test
    fun fieldsAreReadAsTheyWereWritten() {
        val header = FrameHeader.read(ByteBuffer.wrap(dataHeader))
        assertEquals(FrameKind.DATA, header.kind)
        assertEquals(16 shl 20, header.length)
        assertEquals(65535, header.channel)
        assertEquals(-2, header.sequence)
        assertEquals(Long.MIN_VALUE + 123_456_789, header.captureNanos)
        assertEquals(-1, header.sendNanos)
    }

    @Test
    fun flagsAreIgnored() {
        assertEquals(FrameKind.DATA, FrameHeader.read(changed(4 to 0xA5, 5 to 0x5A)).kind)
    }

    @Test
    fun sendTimeIsPatchedWhereTheHeaderStands() {
        val frame = ByteBuffer.allocate(3 + FrameHeader.BYTES).put(byteArrayOf(1, 2, 3)).put(dataHeader)
        FrameHeader.patchSendNanos(frame, headerStart = 3, sendNanos = 0x0102030405060708)
        val expected = byteArrayOf(1, 2, 3) + dataHeader.copyOf(24) + hex("08 07 06 05 04 03 02 01")
        assertContentEquals(expected, frame.array())
    }

    @Test
    fun otherMajorVersionsAreRefused() {
        for (version in listOf(0, 2, 255)) assertRefused(ErrorCode.VERSION, changed(2 to version))
    }

    @Test
    fun everyKindHasTheCodeAndTheBoundOfTheProtocol() {
        val kib = 1024
        val bounds = mapOf(
            1 to 64 * kib, 2 to 64 * kib, 3 to 4 * kib, 4 to 4 * kib, 5 to 64 * kib, 6 to 64 * kib, 7 to 4 * kib,
            8 to 4 * kib, 9 to 4 * kib, 16 to 16 * kib * kib, 32 to 8, 33 to 24, 40 to 4 * kib, 41 to 64 * kib,
            48 to 64 * kib, 49 to 0, 50 to 0, 51 to 4 * kib, 52 to 4 * kib, 53 to 4 * kib,
            60 to 4 * kib, 61 to 16 * kib, 62 to 4 * kib, 96 to 4 * kib, 97 to 4 * kib, 98 to 4 * kib, 99 to 4 * kib,
            112 to 0, 128 to 16 * kib * kib, 129 to 64, 130 to 64 * kib, 131 to 64 * kib, 132 to 4 * kib,
        )
        assertEquals(bounds, FrameKind.entries.associate { it.code to it.maxLength })
        for (code in 0..255) {
            val bound = bounds[code] ?: (64 * kib)
            assertEquals(bound, FrameHeader.read(headerOf(code, bound)).length)
            assertRefused(ErrorCode.TOO_LARGE, headerOf(code, bound + 1))
            if (code !in bounds) assertNull(FrameHeader.read(headerOf(code, bound)).kind)
        }
    }

    private fun assertRefused(code: ErrorCode, header: ByteBuffer) {
        assertEquals(code, assertFailsWith<ProtocolException> { FrameHeader.read(header) }.code)
    }

    private fun changed(vararg bytes: Pair<Int, Int>): ByteBuffer =
        ByteBuffer.wrap(dataHeader.copyOf().also { copy -> bytes.forEach { (at, value) -> copy[at] = value.toByte() } })

    private fun headerOf(kind: Int, length: Int): ByteBuffer =
        ByteBuffer.allocate(FrameHeader.BYTES).also { FrameHeader(kind, length).writeTo(it) }.flip()
}
