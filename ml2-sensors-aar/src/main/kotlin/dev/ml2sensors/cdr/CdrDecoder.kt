package dev.ml2sensors.cdr

import kotlinx.serialization.DeserializationStrategy
import kotlinx.serialization.ExperimentalSerializationApi
import kotlinx.serialization.SerializationException
import kotlinx.serialization.builtins.ByteArraySerializer
import kotlinx.serialization.builtins.DoubleArraySerializer
import kotlinx.serialization.builtins.FloatArraySerializer
import kotlinx.serialization.builtins.IntArraySerializer
import kotlinx.serialization.builtins.LongArraySerializer
import kotlinx.serialization.builtins.ShortArraySerializer
import kotlinx.serialization.builtins.UByteArraySerializer
import kotlinx.serialization.builtins.UIntArraySerializer
import kotlinx.serialization.builtins.ULongArraySerializer
import kotlinx.serialization.builtins.UShortArraySerializer
import kotlinx.serialization.descriptors.SerialDescriptor
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

    override fun beginStructure(descriptor: SerialDescriptor): CompositeDecoder = also {
        descriptor.checkHasCdr()
        if (descriptor.isEmptyMessage) reader.byte()
    }

    @Suppress("UNCHECKED_CAST") // The array that the serializer makes
    override fun <T> decodeSerializableValue(deserializer: DeserializationStrategy<T>): T =
        BLOCKS[deserializer]?.let { it() as T } ?: super.decodeSerializableValue(deserializer)

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

    private fun decodeByteArray(): ByteArray = decodeBytes().let { ByteArray(it.remaining()).also(it::get) }

    private fun decodeShorts(): ShortArray = reader.shorts(decodeLength(Short.SIZE_BYTES))

    private fun decodeInts(): IntArray = reader.ints(decodeLength(Int.SIZE_BYTES))

    private fun decodeLongs(): LongArray = reader.longs(decodeLength(Long.SIZE_BYTES))

    private fun decodeLength(leastElementSize: Int): Int =
        fixedLength?.let { reader.fixedLength(it.length, leastElementSize) } ?: reader.length(leastElementSize)

    override fun decodeNotNullMark(): Boolean = throw SerializationException("CDR has no nullable properties")

    override fun decodeBoolean(): Boolean = reader.boolean()

    override fun decodeByte(): Byte = reader.byte()

    override fun decodeShort(): Short = reader.short()

    override fun decodeInt(): Int = reader.int()

    override fun decodeLong(): Long = reader.long()

    override fun decodeFloat(): Float = reader.float()

    override fun decodeDouble(): Double = reader.double()

    override fun decodeString(): String = reader.string()

    fun decodeWideString(): String = reader.wideString()

    private companion object {
        /** Arrays of numbers, each copied as a whole instead of number by number. */
        @OptIn(ExperimentalUnsignedTypes::class)
        val BLOCKS = mapOf<DeserializationStrategy<*>, CdrDecoder.() -> Any>(
            ByteArraySerializer() to { decodeByteArray() },
            UByteArraySerializer() to { decodeByteArray().asUByteArray() },
            ShortArraySerializer() to { decodeShorts() },
            UShortArraySerializer() to { decodeShorts().asUShortArray() },
            IntArraySerializer() to { decodeInts() },
            UIntArraySerializer() to { decodeInts().asUIntArray() },
            LongArraySerializer() to { decodeLongs() },
            ULongArraySerializer() to { decodeLongs().asULongArray() },
            FloatArraySerializer() to { reader.floats(decodeLength(Float.SIZE_BYTES)) },
            DoubleArraySerializer() to { reader.doubles(decodeLength(Double.SIZE_BYTES)) },
        )
    }
}
