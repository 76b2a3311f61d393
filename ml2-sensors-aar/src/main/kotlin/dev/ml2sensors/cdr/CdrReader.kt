package dev.ml2sensors.cdr

import java.nio.ByteBuffer
import java.nio.ByteOrder
import java.nio.charset.CharacterCodingException

/**
 * Plain little-endian CDR, value by value: the one place that knows byte order and alignment of what is received.
 * Every read is checked against the bytes that remain before anything is allocated.
 */
internal class CdrReader(private val input: ByteArray) {
    private val buffer = ByteBuffer.wrap(input)

    init {
        val header = available(Int.SIZE_BYTES).int
        if (header != CDR_LE) unexpected("encapsulation 0x%08x".format(CDR_LE), "0x%08x".format(header), offset = 0)
        buffer.order(ByteOrder.LITTLE_ENDIAN)
    }

    fun boolean(): Boolean = when (val value = byte().toInt()) {
        0 -> false
        1 -> true
        else -> unexpected("bool of 0 or 1", "${value and 0xff}", buffer.position() - 1)
    }

    fun byte(): Byte = aligned(Byte.SIZE_BYTES).get()

    fun short(): Short = aligned(Short.SIZE_BYTES).short

    fun int(): Int = aligned(Int.SIZE_BYTES).int

    fun long(): Long = aligned(Long.SIZE_BYTES).long

    fun float(): Float = aligned(Float.SIZE_BYTES).float

    fun double(): Double = aligned(Double.SIZE_BYTES).double

    fun string(): String {
        val size = length(Byte.SIZE_BYTES)
        val start = buffer.position()
        if (size == 0) unexpected("string size of at least 1", "0", start - Int.SIZE_BYTES)
        val end = start + size - 1
        if (input[end] != 0.toByte()) unexpected("NUL", "0x%02x".format(input[end]), end)
        buffer.position(end + 1)
        return decodeUtf8(start, end)
    }

    private fun decodeUtf8(start: Int, end: Int): String {
        val text =
            try {
                input.decodeToString(start, end, throwOnInvalidSequence = true)
            } catch (e: CharacterCodingException) {
                unexpected("UTF-8", "invalid bytes", start, e)
            }
        if (NUL in text) unexpected("text without NUL", "one at index ${text.indexOf(NUL)}", start)
        return text
    }

    /** The number of elements that follow, each of at least [leastElementSize] bytes. */
    fun length(leastElementSize: Int): Int {
        val count = Integer.toUnsignedLong(int())
        val most = buffer.remaining() / leastElementSize
        if (count > most) unexpected("length of at most $most", "$count", buffer.position() - Int.SIZE_BYTES)
        return count.toInt()
    }

    /** A view of the input. */
    fun bytes(size: Int): ByteBuffer {
        val view = available(size).slice().limit(size)
        buffer.position(buffer.position() + size)
        return view.slice()
    }

    fun end() {
        if (buffer.hasRemaining()) unexpected("end of message", "${buffer.remaining()} more bytes", buffer.position())
    }

    private fun aligned(size: Int): ByteBuffer {
        val padding = paddingBefore(buffer.position(), size)
        available(padding + size).position(buffer.position() + padding)
        return buffer
    }

    private fun available(size: Int): ByteBuffer {
        if (buffer.remaining() < size) unexpected("$size bytes", "${buffer.remaining()}", buffer.position())
        return buffer
    }

    private fun unexpected(expected: String, found: String, offset: Int, cause: Throwable? = null): Nothing =
        throw CdrDecodingException(expected, found, offset, cause)
}
