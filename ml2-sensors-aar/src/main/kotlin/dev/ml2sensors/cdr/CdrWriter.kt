package dev.ml2sensors.cdr

import java.nio.ByteBuffer
import java.nio.ByteOrder
import java.nio.charset.CharacterCodingException

/** Plain little-endian CDR, value by value: the one place that knows byte order and alignment of what is sent. */
internal class CdrWriter private constructor(private val allocate: (Int) -> ByteBuffer) {
    private var buffer = allocate(INITIAL_CAPACITY)

    init {
        reset()
    }

    /** Starts a new message and discards the last one. */
    fun reset() {
        buffer.clear()
        buffer.order(ByteOrder.BIG_ENDIAN).putInt(CDR_LE).order(ByteOrder.LITTLE_ENDIAN)
    }

    /** A view of what has been written since [reset]; the next [reset] ends its validity. */
    fun written(): ByteBuffer = buffer.duplicate().flip()

    fun byte(value: Byte) {
        aligned(Byte.SIZE_BYTES).put(value)
    }

    fun short(value: Short) {
        aligned(Short.SIZE_BYTES).putShort(value)
    }

    fun int(value: Int) {
        aligned(Int.SIZE_BYTES).putInt(value)
    }

    fun long(value: Long) {
        aligned(Long.SIZE_BYTES).putLong(value)
    }

    fun float(value: Float) {
        aligned(Float.SIZE_BYTES).putFloat(value)
    }

    fun double(value: Double) {
        aligned(Double.SIZE_BYTES).putDouble(value)
    }

    fun string(value: String) {
        require(NUL !in value) { "Expected text without NUL, but found one at index ${value.indexOf(NUL)}" }
        val utf8 =
            try {
                value.encodeToByteArray(throwOnInvalidSequence = true)
            } catch (e: CharacterCodingException) {
                throw IllegalArgumentException("Expected Unicode text, but found an unpaired surrogate", e)
            }
        int(utf8.size + 1)
        reserve(utf8.size + 1).put(utf8).put(0)
    }

    /** Each unit of UTF-16 in four bytes, as Fast DDS sends it; no NUL ends it. */
    fun wideString(value: String) {
        val units = value.toCharArray()
        require(units.unpairedSurrogate() == null) { "Expected Unicode text, but found an unpaired surrogate" }
        int(units.size)
        for (unit in units) int(unit.code)
    }

    fun bytes(value: ByteBuffer) {
        reserve(value.remaining()).put(value.duplicate())
    }

    private fun aligned(size: Int): ByteBuffer {
        val padding = paddingBefore(buffer.position(), size)
        val target = reserve(padding + size)
        repeat(padding) { target.put(0) }
        return target
    }

    private fun reserve(size: Int): ByteBuffer {
        if (buffer.remaining() < size) {
            val needed = Math.addExact(buffer.position(), size)
            val doubled = minOf(buffer.capacity() * 2L, Int.MAX_VALUE.toLong()).toInt()
            buffer = allocate(maxOf(needed, doubled)).put(written()).order(ByteOrder.LITTLE_ENDIAN)
        }
        return buffer
    }

    companion object {
        /** Holds the prefix of an image and most small messages. */
        private const val INITIAL_CAPACITY = 512

        fun onHeap() = CdrWriter(ByteBuffer::allocate)

        fun direct() = CdrWriter(ByteBuffer::allocateDirect)
    }
}

/** The encapsulation header, read as big-endian: representation CDR_LE, then no options. */
internal const val CDR_LE = 0x00_01_00_00

internal const val NUL = '\u0000'

/** The index of a surrogate without the other half beside it, or null if this is Unicode text. */
internal fun CharArray.unpairedSurrogate(): Int? {
    var index = 0
    while (index < size) {
        val isPair = this[index].isHighSurrogate() && index + 1 < size && this[index + 1].isLowSurrogate()
        if (this[index].isSurrogate() && !isPair) return index
        index += if (isPair) 2 else 1
    }
    return null
}

/**
 * Returns the padding before a number of [size] bytes. [position] includes the encapsulation header; alignment is
 * counted from its end.
 */
internal fun paddingBefore(position: Int, size: Int): Int = (Int.SIZE_BYTES - position) and (size - 1)
