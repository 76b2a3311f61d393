package dev.ml2sensors.cdr

import kotlinx.serialization.SerializationStrategy
import java.nio.ByteBuffer

/**
 * One message as CDR in two pieces, so that pixels go from their pool to the socket by a gathering write.
 *
 * @property prefix Everything up to and including the length of the borrowed byte sequence, or the whole message when
 * it has none. A view of the memory of the [PayloadEncoder] that made it, valid until that encodes again.
 * @property data The borrowed bytes, which follow [prefix] directly. Shares the memory of the message's buffer but not
 * its position; the bytes must stay as they are until this payload is written.
 */
internal class Payload(val prefix: ByteBuffer, val data: ByteBuffer?) {
    /** The bytes of the message, encapsulation header included, whatever has been read from the buffers since. */
    val size: Int = Math.addExact(prefix.remaining(), data?.remaining() ?: 0)
}

/**
 * Encodes one message after the other without copying a byte sequence that is the last field: the `data` of an image is
 * borrowed. A byte sequence before other fields is copied.
 *
 * Owns a small direct buffer, which grows to the largest prefix seen and is reused, so that what an encoding allocates
 * on the heap does not depend on the size of an image. To be used by one thread at a time.
 */
internal class PayloadEncoder {
    private val writer = CdrWriter.direct()
    private val encoder = CdrEncoder(writer, borrowsLastBytes = true)

    /**
     * The bytes of [message] as in [Cdr]; they end the validity of the payload returned before.
     *
     * @throws IllegalArgumentException if a message within [message] ends with a byte sequence and others follow, and as in
     * [Cdr].
     */
    fun <T> encode(serializer: SerializationStrategy<T>, message: T): Payload {
        encoder.reset()
        encoder.encodeSerializableValue(serializer, message)
        return Payload(writer.written(), encoder.borrowed)
    }
}
