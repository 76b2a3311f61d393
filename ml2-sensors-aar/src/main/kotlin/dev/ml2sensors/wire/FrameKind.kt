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
    OPEN(96, 4 * KIB),
    OPENED(97, 4 * KIB),
    CLOSE(98, 4 * KIB),
    CLOSED(99, 4 * KIB),
    TAKEN(112, 0),
    MESSAGE(128, 16 * KIB * KIB),
    POSE(129, PoseBody.BYTES),
    REQUEST(130, 64 * KIB),
    RESPONSE(131, 64 * KIB),
    FAILURE(132, 4 * KIB),
    ;

    /** True for the kinds that a session knows only with `ros` in its WELCOME. */
    val isOfOpenings: Boolean get() = code >= FIRST_OF_OPENINGS

    companion object {
        private const val UNKNOWN_MAX_LENGTH = 64 * KIB

        private const val FIRST_OF_OPENINGS = 96
        private val byCode = entries.associateBy(FrameKind::code)

        /** Returns the bound of a kind's body in bytes; null is a kind that is not known, which is skipped. */
        fun maxLength(kind: FrameKind?): Int = kind?.maxLength ?: UNKNOWN_MAX_LENGTH

        /** Returns the kind, or null if this version does not know it. */
        fun of(code: Int): FrameKind? = byCode[code]
    }
}
