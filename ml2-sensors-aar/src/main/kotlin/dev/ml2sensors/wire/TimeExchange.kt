package dev.ml2sensors.wire

import java.nio.ByteBuffer
import java.nio.ByteOrder

/** The four times of one exchange: [t1] and [t4] on the device's clock, [t2] and [t3] in the host's ROS time, all ns. */
internal class TimeExchange(val t1: Long, val t2: Long, val t3: Long, val t4: Long) {
    val roundTripNanos: Long get() = (t4 - t1) - (t3 - t2)

    /** Host minus device; off by at most half the round trip. */
    val offsetNanos: Long get() = (t2 - t1) / 2 + (t3 - t4) / 2 + ((t2 - t1) % 2 + (t3 - t4) % 2) / 2

    companion object {
        const val REQUEST_BYTES: Int = 8
        const val REPLY_BYTES: Int = 24

        fun request(t1: Long): ByteArray =
            ByteBuffer.allocate(REQUEST_BYTES).order(ByteOrder.LITTLE_ENDIAN).putLong(t1).array()

        /** @throws ProtocolException when [body] is not a reply to [expectedT1]. */
        fun ofReply(body: ByteArray, expectedT1: Long, t4: Long): TimeExchange {
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
}
