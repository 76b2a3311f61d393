package dev.ml2sensors.cdr

import kotlinx.serialization.DeserializationStrategy
import kotlinx.serialization.ExperimentalSerializationApi
import kotlinx.serialization.SerializationException
import kotlinx.serialization.descriptors.PrimitiveKind
import kotlinx.serialization.descriptors.SerialDescriptor
import kotlinx.serialization.descriptors.StructureKind
import kotlinx.serialization.encoding.AbstractDecoder
import kotlinx.serialization.encoding.CompositeDecoder
import kotlinx.serialization.modules.SerializersModule
import java.nio.ByteBuffer

/** Walks a message type. Knows what is read in which order; [reader] knows how. */
@OptIn(ExperimentalSerializationApi::class)
internal class CdrDecoder(private val reader: CdrReader) : AbstractDecoder() {
    override val serializersModule: SerializersModule get() = Cdr.serializersModule

    /** The annotation of the property that is decoded next; null for a sequence. */
    private var fixedLength: FixedLength? = null

    override fun decodeSequentially(): Boolean = true

    override fun decodeElementIndex(descriptor: SerialDescriptor): Int =
        throw SerializationException("CDR has no element indices, so ${descriptor.serialName} must read sequentially")

    override fun beginStructure(descriptor: SerialDescriptor): CompositeDecoder = also { descriptor.checkHasCdr() }

    override fun <T> decodeSerializableElement(
        descriptor: SerialDescriptor,
        index: Int,
        deserializer: DeserializationStrategy<T>,
        previousValue: T?,
    ): T {
        fixedLength = descriptor.fixedLength(index)
        return super.decodeSerializableElement(descriptor, index, deserializer, previousValue)
    }

    override fun decodeCollectionSize(descriptor: SerialDescriptor): Int =
        decodeLength(descriptor.getElementDescriptor(0).leastSize())

    fun decodeBytes(): ByteBuffer = reader.bytes(decodeLength(Byte.SIZE_BYTES))

    private fun decodeLength(leastElementSize: Int): Int = fixedLength?.length ?: reader.length(leastElementSize)

    override fun decodeNotNullMark(): Boolean = throw SerializationException("CDR has no nullable properties")

    override fun decodeBoolean(): Boolean = reader.boolean()

    override fun decodeByte(): Byte = reader.byte()

    override fun decodeShort(): Short = reader.short()

    override fun decodeInt(): Int = reader.int()

    override fun decodeLong(): Long = reader.long()

    override fun decodeFloat(): Float = reader.float()

    override fun decodeDouble(): Double = reader.double()

    override fun decodeString(): String = reader.string()
}

/** The fewest bytes a value can take, padding aside: what bounds the number of elements before they are allocated. */
@OptIn(ExperimentalSerializationApi::class)
private fun SerialDescriptor.leastSize(): Int = when (kind) {
    PrimitiveKind.SHORT -> Short.SIZE_BYTES
    PrimitiveKind.INT, PrimitiveKind.FLOAT, StructureKind.LIST -> Int.SIZE_BYTES
    PrimitiveKind.LONG, PrimitiveKind.DOUBLE -> Long.SIZE_BYTES
    PrimitiveKind.STRING -> Int.SIZE_BYTES + 1
    StructureKind.CLASS -> (0 until elementsCount).sumOf { getElementDescriptor(it).leastSize() }
    else -> Byte.SIZE_BYTES
}
