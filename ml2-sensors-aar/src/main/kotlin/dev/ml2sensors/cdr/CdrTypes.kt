package dev.ml2sensors.cdr

import kotlinx.serialization.ExperimentalSerializationApi
import kotlinx.serialization.KSerializer
import kotlinx.serialization.SerialInfo
import kotlinx.serialization.builtins.ByteArraySerializer
import kotlinx.serialization.descriptors.PrimitiveKind
import kotlinx.serialization.descriptors.PrimitiveSerialDescriptor
import kotlinx.serialization.descriptors.SerialDescriptor
import kotlinx.serialization.encoding.Decoder
import kotlinx.serialization.encoding.Encoder
import java.nio.ByteBuffer

/**
 * Makes an array or list property a ROS 2 array `T[length]`, which has no length prefix, instead of a sequence `T[]`.
 * Encoding any other number of elements throws [IllegalArgumentException].
 */
@OptIn(ExperimentalSerializationApi::class)
@SerialInfo
@Target(AnnotationTarget.PROPERTY)
public annotation class FixedLength(val length: Int)

/**
 * A `uint8[]` held as the bytes between position and limit of a buffer, whose position stays as it is.
 *
 * [PayloadEncoder] borrows the bytes, [Cdr] copies them; decoded from CDR the buffer is a view of the input. Other
 * formats see an array of bytes.
 */
public object ByteSequenceSerializer : KSerializer<ByteBuffer> {
    private val arraySerializer = ByteArraySerializer()

    @OptIn(ExperimentalSerializationApi::class)
    override val descriptor: SerialDescriptor = SerialDescriptor("uint8[]", arraySerializer.descriptor)

    override fun serialize(encoder: Encoder, value: ByteBuffer) {
        if (encoder is CdrEncoder) {
            encoder.encodeBytes(value)
        } else {
            arraySerializer.serialize(encoder, ByteArray(value.remaining()).also(value.duplicate()::get))
        }
    }

    override fun deserialize(decoder: Decoder): ByteBuffer =
        if (decoder is CdrDecoder) decoder.decodeBytes() else ByteBuffer.wrap(arraySerializer.deserialize(decoder))
}

/**
 * A `wstring`, which CDR holds in UTF-16 with four bytes for each unit: `uint32` number of units; the units. So Fast DDS
 * sends it in ROS 2 Jazzy. Encoding text with an unpaired surrogate throws [IllegalArgumentException].
 *
 * Other formats see text.
 */
public object WideStringSerializer : KSerializer<String> {
    override val descriptor: SerialDescriptor = PrimitiveSerialDescriptor("wstring", PrimitiveKind.STRING)

    override fun serialize(encoder: Encoder, value: String): Unit =
        if (encoder is CdrEncoder) encoder.encodeWideString(value) else encoder.encodeString(value)

    override fun deserialize(decoder: Decoder): String =
        if (decoder is CdrDecoder) decoder.decodeWideString() else decoder.decodeString()
}
