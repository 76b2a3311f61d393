package dev.ml2sensors.cdr

import kotlinx.serialization.SerializationException
import java.nio.ByteBuffer
import java.nio.ByteOrder
import java.nio.charset.CharacterCodingException

/** The bytes at [offset], counted from the first byte of the encapsulation header, are not the message expected. */
internal class CdrDecodingException(expected: String, found: String, offset: Int, cause: Throwable? = null) :
    SerializationException("Expected $expected, but found $found at offset $offset", cause)

/**
 * Plain little-endian CDR, value by value: the one place that knows byte order and alignment of what is received.
 * Every read is checked against the bytes that remain before anything is allocated. Reads the bytes between position
 * and limit of [input], which stays as it is.
 */
internal class CdrReader(input: ByteBuffer, private val allowsTail: Boolean) {
    private val buffer = input.slice()

    init {
        val header = available(Int.SIZE_BYTES).int
        val found = if (allowsTail) header and OPTIONS.inv() else header
        if (found != CDR_LE) unexpected("encapsulation 0x%08x".format(CDR_LE), "0x%08x".format(header), offset = 0)
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

    fun shorts(count: Int) = ShortArray(count).also { block(count, Short.SIZE_BYTES).asShortBuffer().get(it) }

    fun ints(count: Int) = IntArray(count).also { block(count, Int.SIZE_BYTES).asIntBuffer().get(it) }

    fun longs(count: Int) = LongArray(count).also { block(count, Long.SIZE_BYTES).asLongBuffer().get(it) }

    fun floats(count: Int) = FloatArray(count).also { block(count, Float.SIZE_BYTES).asFloatBuffer().get(it) }

    fun doubles(count: Int) = DoubleArray(count).also { block(count, Double.SIZE_BYTES).asDoubleBuffer().get(it) }

    fun string(): String {
        val size = length(Byte.SIZE_BYTES)
        val start = buffer.position()
        if (size == 0) unexpected("string size of at least 1", "0", start - Int.SIZE_BYTES)
        val utf8 = ByteArray(size - 1).also(buffer::get)
        val end = buffer.get()
        if (end != 0.toByte()) unexpected("NUL", "0x%02x".format(end), start + size - 1)
        val text =
            try {
                utf8.decodeToString(throwOnInvalidSequence = true)
            } catch (e: CharacterCodingException) {
                unexpected("UTF-8", "invalid bytes", start, e)
            }
        if (NUL in text) unexpected("text without NUL", "one at index ${text.indexOf(NUL)}", start)
        return text
    }

    fun wideString(): String {
        val size = length(Int.SIZE_BYTES)
        val start = buffer.position()
        val units = CharArray(size) {
            val unit = int()
            if (unit ushr Char.SIZE_BITS != 0) {
                unexpected("UTF-16", "0x%08x".format(unit), buffer.position() - Int.SIZE_BYTES)
            }
            unit.toChar()
        }
        units.unpairedSurrogate()?.let { unexpected("UTF-16", "an unpaired surrogate", start + it * Int.SIZE_BYTES) }
        return String(units)
    }

    /** The number of elements that follow, each of at least [leastElementSize] bytes. */
    fun length(leastElementSize: Int): Int {
        val count = Integer.toUnsignedLong(int())
        val most = buffer.remaining() / leastElementSize
        if (count > most) unexpected("length of at most $most", "$count", buffer.position() - Int.SIZE_BYTES)
        return count.toInt()
    }

    /** Fails if [count] elements of at least [leastElementSize] bytes cannot follow. */
    fun fixedLength(count: Int, leastElementSize: Int): Int {
        val most = buffer.remaining() / leastElementSize
        if (count > most) unexpected("$count elements", "bytes for at most $most", buffer.position())
        return count
    }

    /** A view of the input, big-endian as every new buffer. */
    fun bytes(size: Int): ByteBuffer = block(size, Byte.SIZE_BYTES).order(ByteOrder.BIG_ENDIAN)

    fun end() {
        if (buffer.hasRemaining() && !allowsTail) {
            unexpected("end of message", "${buffer.remaining()} more bytes", buffer.position())
        }
    }

    /** A view of [count] numbers of [size] bytes, before which there is no padding if there are none. */
    private fun block(count: Int, size: Int): ByteBuffer {
        val padding = if (count == 0) 0 else paddingBefore(buffer.position(), size)
        val start = buffer.position() + padding
        val end = start + count * size
        available(padding + count * size).position(end)
        return buffer.duplicate().position(start).limit(end).slice().order(ByteOrder.LITTLE_ENDIAN)
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

    private companion object {
        /** The second half of the encapsulation header; Cyclone DDS writes there by how many bytes it pads the end. */
        const val OPTIONS = 0xffff
    }
}
