package dev.ml2sensors.wire

import dev.ml2sensors.source.StreamValues
import kotlinx.serialization.SerialName
import kotlinx.serialization.Serializable

// The JSON bodies of PROTOCOL.md, by the names of their kinds.

@Serializable
internal class Hello(
    val versions: List<Int>,
    @SerialName("device_id") val deviceId: String,
    @SerialName("instance_id") val instanceId: String,
    val name: String,
    val software: String,
    val capabilities: Capabilities,
    val permissions: Map<String, Boolean>,
    val channels: Map<String, Status.ChannelCounts> = emptyMap(),
) {
    @Serializable
    class Capabilities(val streams: List<String>, val ros: Boolean = false)
}

@Serializable
internal class Welcome(
    val version: Int,
    val session: String,
    val name: String,
    val software: String,
    val tickets: Map<String, String>,
    val received: Map<String, Long>?,
    val limits: Limits,
    val timeouts: Timeouts,
    val ros: AllowedUses? = null,
) {
    /** For which uses the receiver's user allows any name. */
    @Serializable
    class AllowedUses(val subscribe: Boolean, val publish: Boolean, val call: Boolean, val offer: Boolean)

    @Serializable
    class Limits(@SerialName("data_bytes") val dataBytes: Long)

    @Serializable
    class Timeouts(
        @SerialName("handshake_s") val handshakeSeconds: Double,
        @SerialName("ping_s") val pingSeconds: Double,
        @SerialName("dead_s") val deadSeconds: Double,
    )
}

@Serializable
internal class Join(val session: String, val ticket: String, val lane: String)

@Serializable
internal class Joined(val lane: String)

@Serializable
internal class Configure(
    val request: Long,
    val streams: Map<String, StreamValues>,
    @SerialName("frame_prefix") val framePrefix: String = "",
    val link: Link? = null,
) {
    init {
        require(FRAME_PREFIX.matches(framePrefix)) { "frame_prefix: expected $FRAME_PREFIX" }
    }

    @Serializable
    class Link(val adapts: Boolean, @SerialName("most_mbit_per_s") val mostMbitPerSecond: Double? = null) {
        init {
            require(mostMbitPerSecond == null || mostMbitPerSecond > 0) {
                "most_mbit_per_s: expected a number above 0, found $mostMbitPerSecond"
            }
        }
    }
}

private val FRAME_PREFIX = Regex("[A-Za-z0-9_/]{0,64}")

@Serializable
internal class Configured(val request: Long, val streams: Map<String, StreamAnswer>) {
    @Serializable
    class StreamAnswer(val result: String, val values: StreamValues? = null, val reason: String? = null)
}

@Serializable
internal class ChannelBody(
    val id: Int,
    val stream: String,
    val role: String,
    val topic: String,
    val type: String,
    val qos: String,
    @SerialName("frame_id") val frameId: String,
    val lane: String,
    val will: Will? = null,
) {
    /** The message that the receiver publishes when the channel is silent or ends; [payload] is Base64. */
    @Serializable
    class Will(val payload: String, @SerialName("silent_ms") val silentMillis: Long)
}

@Serializable
internal class ChannelEnd(val id: Int)

@Serializable
internal class Start(val request: Long, val channels: Int? = null) {
    init {
        require(channels == null || channels >= 0) { "channels: counts are not negative, found $channels" }
    }
}

@Serializable
internal class LinkTestBody(val bytes: Int) {
    init {
        require(bytes in 1..LINK_TEST_LIMIT) { "bytes: expected 1 to $LINK_TEST_LIMIT, found $bytes" }
    }
}

private const val LINK_TEST_LIMIT = 64 shl 20

/** The state of a device, once a second: STATUS of PROTOCOL.md. */
@Serializable
public class Status internal constructor(
    internal val final: Boolean,
    @SerialName("uptime_s") internal val uptimeSeconds: Double,
    internal val channels: Map<String, ChannelCounts>,
    internal val clock: Clock,
    internal val thermal: String? = null,
    internal val streams: Map<String, Stream> = emptyMap(),
    internal val openings: Map<String, OpeningCounts> = emptyMap(),
    internal val calls: Map<String, CallCounts> = emptyMap(),
    internal val conditions: Map<String, Condition> = emptyMap(),
) {
    /** Says how well the headset perceives something: [level] `ok` or `warn`, and why. */
    @Serializable
    internal class Condition private constructor(
        val level: String,
        val message: String,
        val values: Map<String, String>,
    ) {
        companion object {
            fun of(isGood: Boolean, message: String, values: Map<String, String>): Condition =
                Condition(if (isGood) "ok" else "warn", message.take(STREAM_REASON_LIMIT), values)
        }
    }

    /** The state of one requested stream. */
    @Serializable
    internal class Stream private constructor(
        val state: String,
        val reason: String? = null,
        val permission: String? = null,
        val quality: Int? = null,
        @SerialName("rate_hz") val rateHz: Int? = null,
    ) {
        /** Returns this state of a stream whose images have a lower [quality] or rate; null means as configured. */
        fun lowered(quality: Int?, rateHz: Int?): Stream = Stream(state, reason, permission, quality, rateHz)

        companion object {
            const val RUNNING = "running"
            const val WAITING = "waiting"
            const val REFUSED = "refused"
            const val AVAILABLE = "available"
            const val FAILED = "failed"

            fun of(state: String, reason: String? = null, permission: String? = null): Stream =
                Stream(state, reason?.ifEmpty { null }?.take(STREAM_REASON_LIMIT), permission)
        }
    }

    /** The counters of a topic since the device started: messages [produced], [sent], and [dropped] by reason. */
    @Serializable
    public class ChannelCounts(
        public val produced: Long,
        public val sent: Long,
        public val dropped: Map<String, Long>,
    )

    /** The counters of a subscription since the app asked for it; the rest of [received] waits in its queue. */
    @Serializable
    internal class OpeningCounts(
        val received: Long,
        val taken: Long,
        val superseded: Long,
        @SerialName("queue_full") val queueFull: Long,
        val undecodable: Long,
    )

    /** The requests of a client or a service since the app made it; the rest of [requests] is under way. */
    @Serializable
    internal class CallCounts(val requests: Long, val responses: Long, val failures: Map<String, Long>)

    /**
     * The state of the device's estimate of ROS time.
     *
     * @property state `waiting`, `synchronised`, `holdover` or `frozen`.
     * @property offsetNanos ROS time minus device time.
     * @property uncertaintyNanos of a stamp, either way.
     * @property roundTripNanos of the best exchange with the receiver.
     * @property skewPpm by which the receiver's clock gains on the device's.
     * @property steps of ROS time, since the device started.
     * @property epoch of the stamps, from 0; counts up whenever they jump.
     * @property bases the clock that stamps each stream, by stream id.
     */
    @Serializable
    public class Clock(
        public val state: String,
        @SerialName("offset_ns") public val offsetNanos: Long,
        @SerialName("uncertainty_ns") public val uncertaintyNanos: Long,
        @SerialName("round_trip_ns") public val roundTripNanos: Long,
        @SerialName("skew_ppm") public val skewPpm: Double? = null,
        public val steps: Long? = null,
        public val epoch: Long? = null,
        public val bases: Map<String, String>? = null,
    )
}

@Serializable
internal class Event(val event: String, val text: String, @SerialName("age_s") val ageSeconds: Double? = null) {
    companion object {
        const val TRACKING_LOST = "tracking_lost"
        const val TRACKING_RECOVERED = "tracking_recovered"
        const val TRACKING_NEW_SESSION = "tracking_new_session"
        const val MAP_LOCALIZED = "map_localized"
        const val MAP_LOST = "map_lost"
        const val GAZE_RELIABLE = "gaze_reliable"
        const val GAZE_UNRELIABLE = "gaze_unreliable"
        const val MOUNTING_STABLE = "mounting_stable"
        const val ADAPTED = "adapted"
        const val SUSPENDED = "suspended"
        const val IMAGES_WITHOUT_POSE = "images_without_pose"
    }
}

@Serializable
internal class ErrorBody(val code: String, val message: String, val fatal: Boolean, val channel: Int? = null) {
    companion object {
        fun of(code: ErrorCode, message: String, fatal: Boolean): ErrorBody =
            ErrorBody(code.wireName, message.take(TEXT_LIMIT), fatal)
    }
}

@Serializable
internal class Bye(val reason: String) {
    companion object {
        fun of(reason: String): Bye = Bye(reason.take(TEXT_LIMIT))
    }
}

/** Characters of which as many as there are streams fit the 64 KiB of a STATUS even when each is escaped. */
private const val STREAM_REASON_LIMIT = 200

/** Characters that fit the 4 KiB of an ERROR or BYE even when each is escaped. */
private const val TEXT_LIMIT = 512
