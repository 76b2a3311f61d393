package dev.ml2sensors.stream

import dev.ml2sensors.clock.StampMap
import dev.ml2sensors.message.Transform
import dev.ml2sensors.pacing.AdaptedStream
import dev.ml2sensors.pacing.ImageSetting
import dev.ml2sensors.source.CaptureMetadata
import dev.ml2sensors.source.DeviceClock
import dev.ml2sensors.source.Distortion
import dev.ml2sensors.source.ImageSample
import dev.ml2sensors.source.InertialSample
import dev.ml2sensors.source.Intrinsics
import dev.ml2sensors.source.PoseSample
import dev.ml2sensors.source.Sample
import dev.ml2sensors.source.VectorSample
import dev.ml2sensors.source.defaultValues
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable
import dev.ml2sensors.wire.FrameWriter
import kotlinx.coroutines.coroutineScope
import kotlinx.coroutines.flow.asFlow
import kotlinx.coroutines.launch
import kotlinx.coroutines.withTimeoutOrNull
import java.nio.ByteBuffer
import java.nio.channels.GatheringByteChannel
import kotlin.time.Duration
import kotlin.time.Duration.Companion.seconds

/**
 * Runs made-up samples of one raw camera, one JPEG camera, one inertial unit and the head through pipelines, lanes and
 * [target], so that the runtime has loaded and compiled that code before the first real sample. Takes [limit] at most.
 */
internal suspend fun warmUp(target: GatheringByteChannel = NullChannel, limit: Duration = 1.seconds) {
    withTimeoutOrNull(limit) {
        coroutineScope {
            val stamps = StampMap(DeviceClock { 0 }).apply { steerTo(offsetNanos = 0, nowNanos = 0) }
            val outgoing = TopicChannels(suspendsWhenFull = true)
            val tree = TransformTree(stamps, isLive = true, TrackingEvents {}) {}
            val channels = SAMPLES.keys.associateWith { outgoing.of(it, it.defaultValues()) }
            val writer = FrameWriter(target) { 0 }
            val lanes = channels.values.flatten().map { it.lane }.distinct()
            lanes.forEach { launch { it.sendThrough(writer) } }
            tree.begin(channels.getValue(StreamTable.tf), FrameIds())
            for ((spec, sample) in SAMPLES) {
                val samples = (1..SAMPLES_OF_EACH).asSequence().map { sample(it * 1000L) }.asFlow()
                val topics = channels.getValue(spec)
                when {
                    spec == StreamTable.tf -> samples.collect(tree::head)

                    spec.isCamera -> {
                        val images =
                            AdaptedStream(spec.id, ImageSetting(spec.modes.first().rates.first(), quality = null))
                        CameraPipeline(spec, topics, stamps, tree, FrameIds(), images).run(samples)
                    }

                    else -> MeasurementPipeline(
                        spec,
                        spec.defaultValues(),
                        topics.single(),
                        stamps,
                        FrameIds(),
                    ).run(samples)
                }
            }
            lanes.forEach { it.finish() }
        }
    }
}

/** Above the number of calls after which HotSpot and ART compile a method. */
private const val SAMPLES_OF_EACH = 300

private val SAMPLES: Map<StreamSpec, (captureNanos: Long) -> Sample> = mapOf(
    StreamTable.tf to { nanos -> PoseSample(nanos, Transform.IDENTITY) },
    StreamTable.imuLeft to
        { nanos -> InertialSample(VectorSample(nanos, 0.0, 0.0, 0.0), VectorSample(nanos, 0.0, 0.0, 0.0)) },
    StreamTable.worldLeft to ::image,
    StreamTable.color to ::image,
)

private fun image(captureNanos: Long): ImageSample = ImageSample(
    captureNanos,
    frameNumber = 0,
    width = SIDE,
    height = SIDE,
    strideBytes = SIDE,
    Transform.IDENTITY,
    LENS,
    CaptureMetadata(),
    listOf(ImageSample.Plane(ImageSample.IMAGE, PIXELS)),
) {}

private const val SIDE = 64
private val PIXELS = ByteBuffer.allocateDirect(SIDE * SIDE)
private val LENS = Intrinsics(SIDE, SIDE, 50.0, 50.0, 32.0, 32.0, Distortion.PlumbBob(0.0, 0.0, 0.0, 0.0, 0.0))

/** Discards what is written. */
private object NullChannel : GatheringByteChannel {
    override fun write(source: ByteBuffer): Int = source.remaining().also { source.position(source.limit()) }

    override fun write(sources: Array<out ByteBuffer>, offset: Int, length: Int): Long =
        (offset until offset + length).sumOf { write(sources[it]).toLong() }

    override fun write(sources: Array<out ByteBuffer>): Long = write(sources, 0, sources.size)

    override fun isOpen(): Boolean = true

    override fun close(): Unit = Unit
}
