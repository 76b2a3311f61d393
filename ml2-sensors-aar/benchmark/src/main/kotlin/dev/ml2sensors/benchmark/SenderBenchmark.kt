package dev.ml2sensors.benchmark

import dev.ml2sensors.message.Header
import dev.ml2sensors.message.Image
import dev.ml2sensors.message.Time
import dev.ml2sensors.session.Lane
import dev.ml2sensors.source.CaptureMetadata
import dev.ml2sensors.source.ImageSample
import dev.ml2sensors.stream.TopicChannel
import dev.ml2sensors.stream.toImage
import dev.ml2sensors.table.StreamTable
import dev.ml2sensors.wire.FrameWriter
import org.openjdk.jmh.annotations.Benchmark
import org.openjdk.jmh.annotations.Level
import org.openjdk.jmh.annotations.Scope
import org.openjdk.jmh.annotations.Setup
import org.openjdk.jmh.annotations.State
import org.openjdk.jmh.annotations.TearDown
import java.nio.ByteBuffer

/** A raw world camera image to a loopback socket that is read as fast as it can be. */
@State(Scope.Thread)
public open class SenderBenchmark {
    private lateinit var sink: LoopbackSink
    private lateinit var writer: FrameWriter
    private lateinit var channel: TopicChannel
    private lateinit var sample: ImageSample
    private lateinit var bareHead: ByteBuffer
    private lateinit var barePieces: Array<ByteBuffer>

    @Setup(Level.Trial)
    public fun open() {
        sink = LoopbackSink()
        writer = FrameWriter(sink.channel) { System.nanoTime() }
        val topic = StreamTable.worldLeft.topics.first()
        channel = TopicChannel(1, topic, Lane(topic.lane, StreamTable.imageLane, suspendsWhenFull = false))
        val pixels = ByteBuffer.allocateDirect(SIDE * SIDE)
        val planes = listOf(ImageSample.Plane(ImageSample.IMAGE, pixels))
        sample =
            ImageSample(0, 0, SIDE, SIDE, SIDE, pose = null, intrinsics = null, CaptureMetadata(), planes) {}
        bareHead = ByteBuffer.allocateDirect(frame().head.remaining())
        barePieces = arrayOf(bareHead, sample.pixels)
    }

    @TearDown(Level.Trial)
    public fun close() {
        sink.close()
    }

    /** Message -> payload -> frame -> gathering write. */
    @Benchmark
    public fun encodeAndWrite() {
        val frame = frame()
        writer.write(frame.head, frame.data)
        frame.sent()
    }

    /** A gathering write of the same bytes. */
    @Benchmark
    public fun bareWrite() {
        barePieces.forEach(ByteBuffer::rewind)
        while (barePieces[1].hasRemaining()) sink.channel.write(barePieces)
    }

    private fun frame() =
        channel.frame(
            Image.serializer(),
            sample.toImage(Header(Time.ofNanos(1), StreamTable.worldLeft.frameId), "mono8", sample.pixels),
            stampNanos = 1,
            sample,
        )

    private companion object {
        const val SIDE = 1016
    }
}
