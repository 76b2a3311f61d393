package dev.ml2sensors.cdr

import kotlinx.serialization.DeserializationStrategy
import kotlinx.serialization.ExperimentalSerializationApi
import kotlinx.serialization.descriptors.SerialDescriptor
import kotlinx.serialization.encoding.AbstractDecoder
import kotlinx.serialization.modules.EmptySerializersModule
import kotlin.random.Random

/** "Decodes" any message type from chance. */
@OptIn(ExperimentalSerializationApi::class)
internal class RandomMessage(private val random: Random) : AbstractDecoder() {
    override val serializersModule = EmptySerializersModule()
    private var fixedLength: FixedLength? = null

    override fun decodeSequentially() = true

    override fun decodeElementIndex(descriptor: SerialDescriptor) = error("sequential")

    override fun <T> decodeSerializableElement(
        descriptor: SerialDescriptor,
        index: Int,
        deserializer: DeserializationStrategy<T>,
        previousValue: T?,
    ): T {
        fixedLength = descriptor.getElementAnnotations(index).filterIsInstance<FixedLength>().singleOrNull()
        return super.decodeSerializableElement(descriptor, index, deserializer, previousValue)
    }

    override fun decodeCollectionSize(descriptor: SerialDescriptor) = fixedLength?.length ?: random.nextInt(5)

    override fun decodeBoolean() = random.nextBoolean()

    override fun decodeByte() = random.nextInt().toByte()

    override fun decodeShort() = random.nextInt().toShort()

    override fun decodeInt() = random.nextInt()

    override fun decodeLong() = random.nextLong()

    override fun decodeFloat() = Float.fromBits(random.nextInt())

    override fun decodeDouble() = Double.fromBits(random.nextLong())

    override fun decodeString() = List(random.nextInt(9)) { LETTERS.random(random) }.joinToString("")

    private companion object {
        val LETTERS = listOf("a", "Z", "/", "_", "\n", "ß", "€", "頭", "😀")
    }
}
