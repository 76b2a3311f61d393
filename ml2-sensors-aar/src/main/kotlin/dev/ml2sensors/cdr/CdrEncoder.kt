package dev.ml2sensors.cdr

import kotlinx.serialization.ExperimentalSerializationApi
import kotlinx.serialization.descriptors.SerialDescriptor
import kotlinx.serialization.encoding.AbstractEncoder
import kotlinx.serialization.encoding.CompositeEncoder
import kotlinx.serialization.modules.SerializersModule
import java.nio.ByteBuffer

/** Walks a message. Knows what is written in which order; [writer] knows how. */
@OptIn(ExperimentalSerializationApi::class)
internal class CdrEncoder(private val writer: CdrWriter, private val borrowsLastBytes: Boolean = false) :
    AbstractEncoder() {
    override val serializersModule: SerializersModule get() = Cdr.serializersModule

    /** The byte sequence at the end of the message, if it was borrowed instead of copied. */
    var borrowed: ByteBuffer? = null
        private set

    /** The annotation of the property that is encoded next; null for a sequence. */
    private var fixedLength: FixedLength? = null

    /** True if nothing follows the property that is encoded next. */
    private var isLast = false

    fun reset() {
        writer.reset()
        borrowed = null
        fixedLength = null
    }

    override fun encodeElement(descriptor: SerialDescriptor, index: Int): Boolean {
        // It was last in a message within this one
        require(borrowed == null) { "Expected the byte sequence last, but found ${descriptor.getElementName(index)}" }
        isLast = index == descriptor.elementsCount - 1
        fixedLength = descriptor.fixedLength(index)
        return true
    }

    override fun beginStructure(descriptor: SerialDescriptor): CompositeEncoder = also {
        descriptor.checkHasCdr()
        if (descriptor.isEmptyMessage) writer.byte(0)
    }

    override fun beginCollection(descriptor: SerialDescriptor, collectionSize: Int): CompositeEncoder {
        encodeLength(collectionSize)
        return beginStructure(descriptor)
    }

    fun encodeBytes(value: ByteBuffer) {
        encodeLength(value.remaining())
        if (borrowsLastBytes && isLast) borrowed = value.duplicate() else writer.bytes(value)
    }

    private fun encodeLength(length: Int) {
        val fixed = fixedLength ?: return writer.int(length)
        require(length == fixed.length) { "Expected ${fixed.length} elements, but found $length" }
    }

    // A nullable property is refused whatever its value
    override fun encodeNotNullMark() = encodeNull()

    override fun encodeBoolean(value: Boolean) = writer.byte(if (value) 1 else 0)

    override fun encodeByte(value: Byte) = writer.byte(value)

    override fun encodeShort(value: Short) = writer.short(value)

    override fun encodeInt(value: Int) = writer.int(value)

    override fun encodeLong(value: Long) = writer.long(value)

    override fun encodeFloat(value: Float) = writer.float(value)

    override fun encodeDouble(value: Double) = writer.double(value)

    override fun encodeString(value: String) = writer.string(value)

    fun encodeWideString(value: String) = writer.wideString(value)
}
