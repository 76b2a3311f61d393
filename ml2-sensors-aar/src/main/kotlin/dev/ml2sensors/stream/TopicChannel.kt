package dev.ml2sensors.stream

import dev.ml2sensors.cdr.PayloadEncoder
import dev.ml2sensors.session.ChannelCounters
import dev.ml2sensors.session.Lane
import dev.ml2sensors.session.OutgoingFrame
import dev.ml2sensors.source.ImageSample
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.TopicSpec
import dev.ml2sensors.wire.ChannelBody
import dev.ml2sensors.wire.FrameHeader
import dev.ml2sensors.wire.FrameKind
import kotlinx.serialization.SerializationStrategy
import java.nio.ByteBuffer

/** Encodes the messages of one topic as frames and passes them to its lane. Used by one coroutine at a time. */
internal class TopicChannel(
    val id: Int,
    val topic: TopicSpec,
    val lane: Lane,
    val will: Will? = null,
) {
    val counters = ChannelCounters()
    private val encoder = PayloadEncoder()

    /**
     * Encodes and queues a message captured at [stampNanos], ROS time. Memory of [sample] in the payload is retained
     * until the frame is sent or dropped.
     */
    suspend fun <T> publish(
        serializer: SerializationStrategy<T>,
        message: T,
        stampNanos: Long,
        sample: ImageSample? = null,
    ) {
        lane.offer(frame(serializer, message, stampNanos, sample))
    }

    /** Returns the next frame of this channel with a copy of [payload], a whole message from position to limit. */
    fun frame(payload: ByteBuffer, stampNanos: Long): OutgoingFrame {
        val header = FrameHeader(FrameKind.DATA.code, payload.remaining(), id, counters.nextSequence(), stampNanos)
        val head = ByteBuffer.allocate(FrameHeader.BYTES + payload.remaining())
        header.writeTo(head)
        head.put(payload.duplicate()).flip()
        return OutgoingFrame(counters, head, data = null, sample = null)
    }

    /** Returns the next frame of this channel. The caller offers it to a lane, or calls its `sent` or `drop`. */
    fun <T> frame(
        serializer: SerializationStrategy<T>,
        message: T,
        stampNanos: Long,
        sample: ImageSample?,
    ): OutgoingFrame {
        val payload = encoder.encode(serializer, message)
        val header = FrameHeader(FrameKind.DATA.code, payload.size, id, counters.nextSequence(), stampNanos)
        // The prefix is the encoder's until it encodes again, and several frames may be queued.
        val head = ByteBuffer.allocate(FrameHeader.BYTES + payload.prefix.remaining())
        header.writeTo(head)
        head.put(payload.prefix).flip()
        val borrowed = if (payload.data == null) null else sample
        borrowed?.retain()
        return OutgoingFrame(counters, head, payload.data, borrowed)
    }

    /** Returns the body of CHANNEL for this topic of [spec]. */
    fun describe(spec: StreamSpec, frameIds: FrameIds): ChannelBody =
        ChannelBody(
            id,
            spec.id,
            topic.role,
            topic.name,
            topic.type,
            topic.qos,
            frameIds.of(spec),
            topic.lane,
            will?.body,
        )
}
