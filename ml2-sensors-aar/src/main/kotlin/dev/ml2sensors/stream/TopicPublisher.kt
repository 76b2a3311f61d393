package dev.ml2sensors.stream

import dev.ml2sensors.clock.StampMap
import java.nio.ByteBuffer

/**
 * A topic of the app's own beside the headset's, made by [Ml2Streamer.publisher]. Its messages go to ROS through the
 * same session, whenever there is one whose receiver lets the app publish (`custom.enabled`).
 *
 * Any thread.
 */
public class TopicPublisher internal constructor(internal val channel: TopicChannel, private val stamps: StampMap) {
    @Volatile
    private var isOpen = false

    /** Why the receiver takes none at all. */
    @Volatile
    internal var allRefusal: String? = null

    @Volatile
    private var ownRefusal: String? = null

    /**
     * Why this receiver does not publish it, such as `custom.enabled` being false or a type that it does not have; null
     * as long as it does, and while there is no receiver.
     */
    public val refusal: String? get() = ownRefusal ?: allRefusal

    /** Relative to the receiver's prefix: `custom/NAME`. */
    public val topic: String get() = channel.topic.name

    /** Of its messages, as ROS 2 writes it: `PACKAGE/msg/NAME`. */
    public val type: String get() = channel.topic.type

    /**
     * Sends one message, captured at [captureNanos] on the headset's clock: not more than a second ahead of it, as wall
     * clock time would be, or the message is dropped as `future_capture`. The book `produced` has it only if a receiver
     * takes the topic at present; what is lost on the way from here is counted too.
     *
     * @param payload the whole message as plain little-endian CDR behind `00 01 00 00`, from position to limit; copied.
     * @return whether it was handed over, which is false without a receiver that takes it, and for a dropped message.
     */
    @Synchronized
    public fun publish(payload: ByteBuffer, captureNanos: Long): Boolean {
        require(payload.remaining() in ENCAPSULATION.size..MAX_BYTES) {
            "a message has ${ENCAPSULATION.size} to $MAX_BYTES bytes, not ${payload.remaining()}"
        }
        require(ENCAPSULATION.indices.all { payload[payload.position() + it] == ENCAPSULATION[it] }) {
            "a message begins with 00 01 00 00, plain little-endian CDR"
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

        /** Of DATA on the lane `sensors`. */
        const val MAX_BYTES = 64 * 1024
    }
}
