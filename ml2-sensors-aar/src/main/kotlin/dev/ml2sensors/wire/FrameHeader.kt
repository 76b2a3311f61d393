package dev.ml2sensors.wire

import java.nio.ByteBuffer
import java.nio.ByteOrder

/** The 32 bytes before every body. [kind] is null if this version does not know [kindCode]. */
internal class FrameHeader(
    val kindCode: Int,
    val length: Int,
    val channel: Int = 0,
    val sequence: Int = 0,
    val captureNanos: Long = 0,
    val sendNanos: Long = 0,
) {
    val kind: FrameKind? get() = FrameKind.of(kindCode)

    /** Appends the header to [target], whatever its byte order. */
    fun writeTo(target: ByteBuffer) {
        val order = target.order()
        target.order(ByteOrder.LITTLE_ENDIAN)
            .putShort(MAGIC.toShort()).put(VERSION.toByte()).put(kindCode.toByte())
            .putShort(0).putShort(channel.toShort()).putInt(sequence).putInt(length)
            .putLong(captureNanos).putLong(sendNanos)
            .order(order)
    }

    companion object {
        const val BYTES: Int = 32
        const val VERSION: Int = 1
        private const val MAGIC = 0x324D
        private const val SEND_OFFSET = 24

        /** Writes the send time into the header at [headerStart] of [frame]. */
        fun patchSendNanos(frame: ByteBuffer, headerStart: Int, sendNanos: Long) {
            val order = frame.order()
            frame.order(ByteOrder.LITTLE_ENDIAN).putLong(headerStart + SEND_OFFSET, sendNanos).order(order)
        }

        /**
         * Reads and checks the next 32 bytes of [source].
         *
         * @param maxLength returns the bound of a kind's body in bytes; null is an unknown kind.
         * @throws ProtocolException for a wrong magic or version, or a length above the kind's bound.
         */
        fun read(source: ByteBuffer, maxLength: (FrameKind?) -> Int = FrameKind::maxLength): FrameHeader {
            source.order(ByteOrder.LITTLE_ENDIAN)
            val magic = source.short.toInt() and 0xFFFF
            val version = source.get().toInt() and 0xFF
            val code = source.get().toInt() and 0xFF
            source.short // flags
            val channel = source.short.toInt() and 0xFFFF
            val sequence = source.int
            val length = source.int.toLong() and 0xFFFF_FFFFL
            if (magic != MAGIC) {
                throw ProtocolException(ErrorCode.MALFORMED, "expected magic %04x, found %04x".format(MAGIC, magic))
            }
            if (version != VERSION) {
                throw ProtocolException(ErrorCode.VERSION, "expected protocol version $VERSION, found $version")
            }
            val bound = maxLength(FrameKind.of(code))
            if (length > bound) {
                throw ProtocolException(
                    ErrorCode.TOO_LARGE,
                    "expected at most $bound bytes of kind $code, found $length",
                )
            }
            return FrameHeader(code, length.toInt(), channel, sequence, source.long, source.long)
        }
    }
}
