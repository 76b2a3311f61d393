package dev.ml2sensors.stream

import dev.ml2sensors.clock.StampMap
import dev.ml2sensors.message.Time
import dev.ml2sensors.ros.WHICH_DOES
import dev.ml2sensors.source.DropReason
import dev.ml2sensors.table.StreamTable
import dev.ml2sensors.wire.ChannelBody
import java.nio.ByteBuffer
import java.nio.ByteOrder
import kotlin.io.encoding.Base64
import kotlin.time.Duration
import kotlin.time.Duration.Companion.milliseconds
import kotlin.time.Duration.Companion.seconds

/**
 * Publishes messages on a topic of the app's own, made by [Ml2Streamer.publisher]. They go to ROS through the
 * streamer's session while its receiver accepts them (`custom.enabled`). Thread-safe.
 */
public class TopicPublisher internal constructor(internal val channel: TopicChannel, private val stamps: StampMap) {
    @Volatile
    private var isOpen = false

    /** The reason why the receiver accepts no topics from the app. */
    @Volatile
    internal var allRefusal: String? = null

    @Volatile
    private var ownRefusal: String? = null

    /**
     * The reason why this receiver does not publish the topic, such as `custom.enabled: false` or a type that it does
     * not have; null if it does, and while there is no receiver.
     */
    public val refusal: String? get() = ownRefusal ?: allRefusal

    internal val isLatched: Boolean get() = channel.topic.qos == StreamTable.customTopics.latchedQos

    internal val isLarge: Boolean get() = channel.topic.laneClass == StreamTable.customTopics.large

    /** True for what receivers know that serve no apps. */
    internal val isPlain: Boolean
        get() = !isLatched && !isLarge && channel.will == null && !topic.startsWith("/")

    /** The topic relative to the receiver's prefix, `custom/NAME`, or absolute. */
    public val topic: String get() = channel.topic.name

    /** The type of its messages, as ROS 2 writes it: `PACKAGE/msg/NAME`. */
    public val type: String get() = channel.topic.type

    /**
     * Sends one message, captured at [captureNanos] on the headset's clock. A time more than a second ahead of it, such
     * as wall clock time, drops the message as `future_capture`. The counter `produced` includes the message only if a
     * receiver accepts the topic; messages lost afterwards are counted too.
     *
     * @param payload the whole message as plain little-endian CDR after `00 01 00 00`, from position to limit; copied.
     * It has at most 64 KiB, or 16 MiB if the topic is one of large messages.
     * @return true if it was queued; false without a receiver that accepts it, and for a dropped message.
     */
    public fun publish(payload: ByteBuffer, captureNanos: Long): Boolean =
        publish(payload, captureNanos, isStamped = false)

    /** As the other one. If the message [isStamped], it begins with a header, whose stamp is written into [payload]. */
    @Synchronized
    internal fun publish(payload: ByteBuffer, captureNanos: Long, isStamped: Boolean): Boolean {
        requireMessage(payload, channel.topic.laneClass.maxPayloadBytes)
        if (!isOpen) return false
        val stampNanos = stamps.stampNanos(captureNanos)
        if (stampNanos == null) {
            channel.counters.countLost(1, stamps.lossReason(captureNanos))
            return false
        }
        if (isStamped) payload.putStamp(Time.ofNanos(stampNanos))
        channel.lane.offerNow(channel.frame(payload, stampNanos))
        return true
    }

    /** Counts [count] messages that newer ones have replaced before they could be published. */
    @Synchronized
    internal fun lose(count: Int) {
        if (isOpen) channel.counters.countLost(count, DropReason.QUEUE_FULL)
    }

    internal fun open() {
        isOpen = refusal == null
    }

    internal fun refuse(reason: String) {
        ownRefusal = reason
        isOpen = false
    }

    internal fun reset(servesApps: Boolean) {
        ownRefusal = if (servesApps || isPlain) null else "the receiver serves no apps: $WHICH_DOES"
        isOpen = false
    }
}

/**
 * The message that the receiver publishes on a topic when the app falls silent: the last word of a dead man's switch.
 *
 * The receiver publishes it once when no message has come for [silence], and once when the topic or the session ends: the
 * app stops or is killed, or the connection is lost. Before the first message, and until another one, it publishes
 * nothing. A stamp inside the message is the one it was made with.
 *
 * @param message plain little-endian CDR after `00 01 00 00`, at most 2048 bytes, from position to limit; copied.
 * @property silence from 50 ms to 5 s, in whole milliseconds.
 */
public class Will(message: ByteBuffer, public val silence: Duration) {
    private val payload = ByteArray(message.remaining())

    init {
        requireMessage(message, MOST_BYTES)
        require(silence in SHORTEST..LONGEST && silence == silence.inWholeMilliseconds.milliseconds) {
            "silence: expected $SHORTEST to $LONGEST in whole milliseconds, found $silence"
        }
        message.duplicate().get(payload)
    }

    internal val body get() = ChannelBody.Will(Base64.encode(payload), silence.inWholeMilliseconds)

    private companion object {
        const val MOST_BYTES = 2048
        val SHORTEST = 50.milliseconds
        val LONGEST = 5.seconds
    }
}

private val ENCAPSULATION = byteArrayOf(0, 1, 0, 0)

private fun ByteBuffer.putStamp(stamp: Time) {
    require(remaining() >= ENCAPSULATION.size + Long.SIZE_BYTES) {
        "a message with a header has more than ${remaining()} bytes"
    }
    val bytes = duplicate().order(ByteOrder.LITTLE_ENDIAN)
    bytes.position(bytes.position() + ENCAPSULATION.size)
    bytes.putInt(stamp.sec).putInt(stamp.nanosec.toInt())
}

private fun requireMessage(payload: ByteBuffer, maxBytes: Int) {
    require(payload.remaining() in ENCAPSULATION.size..maxBytes) {
        "a message has ${ENCAPSULATION.size} to $maxBytes bytes, not ${payload.remaining()}"
    }
    require(ENCAPSULATION.indices.all { payload[payload.position() + it] == ENCAPSULATION[it] }) {
        "a message must begin with 00 01 00 00, plain little-endian CDR"
    }
}
