package dev.ml2sensors.wire

import kotlinx.serialization.SerialName
import kotlinx.serialization.Serializable
import java.nio.ByteBuffer
import java.nio.ByteOrder

// The bodies of openings in PROTOCOL.md, by the names of their kinds.

@Serializable
internal class Open(
    val id: Int,
    val kind: String,
    val name: String? = null,
    val type: String? = null,
    val hash: String? = null,
    val layout: String? = null,
    val keep: String? = null,
    val depth: Int? = null,
    @SerialName("max_hz") val maxHz: Double? = null,
    val bulk: Boolean? = null,
    val received: Long? = null,
    val frame: String? = null,
    val reference: String? = null,
) {
    companion object {
        const val SUBSCRIPTION = "subscription"
        const val CLIENT = "client"
        const val SERVICE = "service"
        const val TRANSFORM = "transform"
    }
}

@Serializable
internal class Opened(
    val id: Int,
    val result: String,
    val latched: Boolean = false,
    val lane: String? = null,
    val reason: String? = null,
    val code: String? = null,
    val name: String? = null,
    val checked: String? = null,
) {
    val isOpen: Boolean get() = result == OPENED

    init {
        requireId(id)
        require(result == OPENED || result == REFUSED) { "result: expected $OPENED or $REFUSED, found $result" }
        require(lane == null || lane in RosLanes.ALL) { "lane: expected one of ${RosLanes.ALL}, found $lane" }
        require(!isOpen || lane != null) { "lane: missing although $OPENED" }
        require(isOpen || reason != null) { "reason: missing although $REFUSED" }
        require(name == null || isShort(name, NAME_LIMIT)) { "name: expected 1 to $NAME_LIMIT printable characters" }
        require(checked == null || checked in CHECKED) { "checked: expected one of $CHECKED, found $checked" }
    }

    companion object {
        private const val OPENED = "opened"
        private const val REFUSED = "refused"
        private const val NAME_LIMIT = 255
        private val CHECKED = setOf("hash", "layout", "no")
    }
}

@Serializable
internal class Close(val id: Int)

@Serializable
internal class Closed(val id: Int, val reason: String, val code: String? = null) {
    init {
        requireId(id)
    }
}

@Serializable
internal class Failure(val code: String, val message: String) {
    companion object {
        const val TIMEOUT = "timeout"
        const val REFUSED = "refused"
        const val MALFORMED = "malformed"
        const val TOO_LARGE = "too_large"
        const val BUSY = "busy"

        /** Not sent, but counted. */
        const val LINK_DOWN = "link_down"
        const val CANCELLED = "cancelled"
        const val OTHER = "other"
    }
}

/** A position in m, a unit quaternion, and the stamp in ns that shows how stale they are. */
internal class PoseBody private constructor(val numbers: DoubleArray, val newestNanos: Long) {
    companion object {
        const val BYTES: Int = 64
        private const val NUMBERS = 7

        /** @throws ProtocolException when [body] is no pose of finite numbers. */
        fun parse(body: ByteArray): PoseBody {
            if (body.size != BYTES) {
                throw ProtocolException(ErrorCode.MALFORMED, "expected a pose of $BYTES bytes, found ${body.size}")
            }
            val bytes = ByteBuffer.wrap(body).order(ByteOrder.LITTLE_ENDIAN)
            val numbers = DoubleArray(NUMBERS) { bytes.double }
            if (!numbers.all(Double::isFinite)) {
                throw ProtocolException(ErrorCode.MALFORMED, "expected finite numbers, found ${numbers.asList()}")
            }
            return PoseBody(numbers, bytes.long)
        }
    }
}

/** The lanes of openings. */
internal object RosLanes {
    const val ROS = "ros"
    val ALL: List<String> = listOf(ROS, "bulk_1", "bulk_2", "bulk_3", "bulk_4")

    /** Returns the length of the greatest MESSAGE on [lane], in bytes. */
    fun maxMessageBytes(lane: String): Int =
        if (lane == ROS) FrameKind.REQUEST.maxLength else FrameKind.MESSAGE.maxLength
}

private fun requireId(id: Int) = require(id in 1..MAX_ID) { "id: expected 1 to $MAX_ID, found $id" }

private const val MAX_ID = 0xFFFF
