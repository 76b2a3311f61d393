package dev.ml2sensors.wire

private const val KIB = 1024

/** The kinds of PROTOCOL.md with the largest body each may have, in bytes. */
internal enum class FrameKind(val code: Int, val maxLength: Int) {
    HELLO(1, 64 * KIB),
    WELCOME(2, 64 * KIB),
    JOIN(3, 4 * KIB),
    JOINED(4, 4 * KIB),
    CONFIGURE(5, 64 * KIB),
    CONFIGURED(6, 64 * KIB),
    CHANNEL(7, 4 * KIB),
    CHANNEL_END(8, 4 * KIB),
    START(9, 4 * KIB),
    DATA(16, 16 * KIB * KIB),
    TIME_REQUEST(32, TimeBodies.REQUEST_BYTES),
    TIME_REPLY(33, TimeBodies.REPLY_BYTES),
    LINK_TEST(40, 4 * KIB),
    FILLER(41, 64 * KIB),
    STATUS(48, 64 * KIB),
    PING(49, 0),
    PONG(50, 0),
    ERROR(51, 4 * KIB),
    BYE(52, 4 * KIB),
    EVENT(53, 4 * KIB),
    PAIR_CHALLENGE(60, 4 * KIB),
    PAIR(61, 16 * KIB),
    PAIRED(62, 4 * KIB),
    ;

    companion object {
        /** The length limit of kinds that this version does not know, which are skipped. */
        const val UNKNOWN_MAX_LENGTH: Int = 64 * KIB

        private val byCode = entries.associateBy(FrameKind::code)

        /** Returns the kind, or null if this version does not know it. */
        fun of(code: Int): FrameKind? = byCode[code]
    }
}
