package dev.ml2sensors.wire

import dev.ml2sensors.clock.TimeExchange
import java.nio.ByteBuffer
import java.nio.ByteOrder

/** The bodies of time frames: i64 ns, little endian. */
internal object TimeBodies {
    const val REQUEST_BYTES: Int = 8
    const val REPLY_BYTES: Int = 24

    fun request(t1: Long): ByteArray =
        ByteBuffer.allocate(REQUEST_BYTES).order(ByteOrder.LITTLE_ENDIAN).putLong(t1).array()

    /**
     * Returns the exchange that [body] completes, or null if it does not answer [request] or is impossible.
     *
     * @throws ProtocolException when [body] is not a time reply.
     */
    fun exchange(request: Long, body: ByteArray, t4: Long): TimeExchange? {
        if (body.size != REPLY_BYTES) {
            throw ProtocolException(
                ErrorCode.MALFORMED,
                "expected a time reply of $REPLY_BYTES bytes, found ${body.size}",
            )
        }
        val times = ByteBuffer.wrap(body).order(ByteOrder.LITTLE_ENDIAN)
        val t1 = times.long
        val t2 = times.long
        val t3 = times.long
        val isPossible = t3 >= t2 && t3 - t2 in 0..t4 - t1
        return if (t1 == request && isPossible) TimeExchange(t1, t2, t3, t4) else null
    }
}
