package dev.ml2sensors.cdr

import kotlinx.serialization.BinaryFormat
import kotlinx.serialization.DeserializationStrategy
import kotlinx.serialization.ExperimentalSerializationApi
import kotlinx.serialization.SerializationException
import kotlinx.serialization.SerializationStrategy
import kotlinx.serialization.modules.EmptySerializersModule
import kotlinx.serialization.modules.SerializersModule
import java.nio.ByteBuffer

/**
 * The bytes ROS 2 puts on the network for a message: plain CDR, little-endian, behind the encapsulation header
 * `00 01 00 00`. There is this one encoding and nothing to configure. Source: OMG DDSI-RTPS 2.5 section 10 and
 * DDS-XTypes 1.3 section 7.4 (XCDR version 1).
 *
 * A message is a `@Serializable` class whose properties are declared in the order of the `.msg` file:
 *
 * | Kotlin | ROS 2 | bytes |
 * |---|---|---|
 * | `Boolean` | `bool` | 1, of value 0 or 1 |
 * | `Byte`, `UByte`, `Short`, `UShort`, `Int`, `UInt`, `Long`, `ULong` | `int8` to `uint64` | their size |
 * | `Float`, `Double` | `float32`, `float64` | IEEE 754 |
 * | `String` | `string` | `uint32` size in bytes of UTF-8 and NUL; UTF-8; NUL |
 * | `String` with [WideStringSerializer] | `wstring` | `uint32` number of units; each unit of UTF-16 as a `uint32` |
 * | `List`, `DoubleArray` and the like | `T[]` | `uint32` number of elements; the elements |
 * | the same with [FixedLength] | `T[N]` | the elements |
 * | `ByteBuffer` with [ByteSequenceSerializer] | `uint8[]` | `uint32` number of bytes; the bytes |
 * | another such class | a nested message | its properties in order |
 * | a class or object without properties | a message without fields | 1, written as 0 and ignored when read |
 *
 * A number is aligned to its own size, counted from the end of the encapsulation header. Padding is written as zeros
 * and ignored when read.
 *
 * **Known caveats.** Enums, maps, nullable and polymorphic properties have no ROS 2 counterpart here and throw
 * [SerializationException]. Text with an unpaired surrogate or a NUL, and an array that contradicts its [FixedLength],
 * throw [IllegalArgumentException]. The decoder refuses bytes after the message, unless [decode] is told to allow
 * them, and encapsulations other than the one above.
 *
 * [PayloadEncoder] is the way to encode without copying an image. This object is safe for use by several threads.
 */
@OptIn(ExperimentalSerializationApi::class)
public object Cdr : BinaryFormat {
    override val serializersModule: SerializersModule = EmptySerializersModule()

    override fun <T> encodeToByteArray(serializer: SerializationStrategy<T>, value: T): ByteArray {
        val writer = CdrWriter.onHeap()
        CdrEncoder(writer).encodeSerializableValue(serializer, value)
        return writer.written().let { bytes -> ByteArray(bytes.remaining()).also(bytes::get) }
    }

    /**
     * Byte sequences of the result are views of [bytes], which must not change while they are in use.
     *
     * @throws SerializationException if [bytes] are not exactly one message, naming what was expected, what was found,
     * and where. No allocation is larger than the number of [bytes] warrants.
     */
    override fun <T> decodeFromByteArray(deserializer: DeserializationStrategy<T>, bytes: ByteArray): T =
        decode(deserializer, ByteBuffer.wrap(bytes))

    /**
     * Decodes the message between position and limit of [bytes], which may be a direct buffer and stays as it is. Byte
     * sequences of the result are views of it. Arrays of numbers are copied as a whole.
     *
     * @param allowsTail ignores bytes after the message, and the options in the encapsulation header. Other writers fill
     * both: rclpy's `serialize_message` leaves bytes behind a message, and Cyclone DDS pads it.
     * @throws SerializationException as [decodeFromByteArray].
     */
    public fun <T> decode(
        deserializer: DeserializationStrategy<T>,
        bytes: ByteBuffer,
        allowsTail: Boolean = false,
    ): T {
        val reader = CdrReader(bytes, allowsTail)
        return CdrDecoder(reader).decodeSerializableValue(deserializer).also { reader.end() }
    }
}
