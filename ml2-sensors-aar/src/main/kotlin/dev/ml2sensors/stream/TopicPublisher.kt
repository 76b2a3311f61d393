package dev.ml2sensors.stream

import dev.ml2sensors.clock.StampMap
import java.nio.ByteBuffer

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

    /** The topic relative to the receiver's prefix: `custom/NAME`. */
    public val topic: String get() = channel.topic.name

    /** The type of its messages, as ROS 2 writes it: `PACKAGE/msg/NAME`. */
    public val type: String get() = channel.topic.type

    /**
     * Sends one message, captured at [captureNanos] on the headset's clock. A time more than a second ahead of it, such
     * as wall clock time, drops the message as `future_capture`. The counter `produced` includes the message only if a
     * receiver accepts the topic; messages lost afterwards are counted too.
     *
     * @param payload the whole message as plain little-endian CDR after `00 01 00 00`, from position to limit; copied.
     * @return true if it was queued; false without a receiver that accepts it, and for a dropped message.
     */
    @Synchronized
    public fun publish(payload: ByteBuffer, captureNanos: Long): Boolean {
        require(payload.remaining() in ENCAPSULATION.size..MAX_BYTES) {
            "a message has ${ENCAPSULATION.size} to $MAX_BYTES bytes, not ${payload.remaining()}"
        }
        require(ENCAPSULATION.indices.all { payload[payload.position() + it] == ENCAPSULATION[it] }) {
            "a message must begin with 00 01 00 00, plain little-endian CDR"
        }
        if (!isOpen) return false
        val stampNanos = stamps.stampNanos(captureNanos)
        if (stampNanos == null) {
            channel.counters.countLost(1, stamps.lossReason(captureNanos))
            return false
        }
        channel.lane.offerNow(channel.frame(payload, stampNanos))
        return true
    }

    internal fun open() {
        isOpen = refusal == null
    }

    internal fun refuse(reason: String) {
        ownRefusal = reason
        isOpen = false
    }

    internal fun reset() {
        ownRefusal = null
        isOpen = false
    }

    private companion object {
        val ENCAPSULATION = byteArrayOf(0, 1, 0, 0)

        /** The limit of DATA on the lane `sensors`. */
        const val MAX_BYTES = 64 * 1024
    }
}
