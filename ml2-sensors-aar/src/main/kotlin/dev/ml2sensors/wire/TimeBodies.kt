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

    /** @throws ProtocolException when [body] is not the reply to the request of [expectedT1]. */
    fun exchange(body: ByteArray, expectedT1: Long, t4: Long): TimeExchange {
        if (body.size != REPLY_BYTES) {
            throw ProtocolException(ErrorCode.MALFORMED, "expected a time reply of $REPLY_BYTES bytes, found ${body.size}")
        }
        val times = ByteBuffer.wrap(body).order(ByteOrder.LITTLE_ENDIAN)
        val t1 = times.long
        if (t1 != expectedT1) {
            throw ProtocolException(ErrorCode.MALFORMED, "expected a reply to time request $expectedT1, found $t1")
        }
        return TimeExchange(t1, times.long, times.long, t4)
    }
}
