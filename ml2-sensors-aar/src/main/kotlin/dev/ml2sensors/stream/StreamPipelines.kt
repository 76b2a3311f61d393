package dev.ml2sensors.stream

import dev.ml2sensors.capture.ImageCodec
import dev.ml2sensors.capture.ImageEncoder
import dev.ml2sensors.capture.VideoChannel
import dev.ml2sensors.capture.VideoStream
import dev.ml2sensors.clock.StampMap
import dev.ml2sensors.pacing.AdaptedStream
import dev.ml2sensors.pacing.ImageSetting
import dev.ml2sensors.source.DropReason
import dev.ml2sensors.source.ImageSample
import dev.ml2sensors.source.MarkersSample
import dev.ml2sensors.source.PoseSample
import dev.ml2sensors.source.Sample
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.source.VideoEncoders
import dev.ml2sensors.source.topics
import dev.ml2sensors.source.video
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable
import dev.ml2sensors.wire.Event
import kotlinx.coroutines.flow.Flow
import kotlinx.coroutines.flow.onEach

/**
 * Publishes the samples of streams on their channels.
 *
 * @param videoEncoders of the headset; null if it has none.
 */
internal class StreamPipelines(
    private val outgoing: TopicChannels,
    private val stamps: StampMap,
    private val tree: TransformTree,
    private val adaptation: ImageAdaptation,
    private val videoEncoders: VideoEncoders?,
    private val conditions: Conditions,
    private val report: (Event) -> Unit,
) {
    /** Publishes [samples] of the stream [spec] until they end or fail. */
    suspend fun run(
        spec: StreamSpec,
        values: StreamValues,
        frameIds: FrameIds,
        samples: Flow<Sample>,
    ) {
        val channels = outgoing.of(spec, values)
        when {
            spec == StreamTable.tf -> {
                tree.beginTrack()
                conditions.watch(Conditions.TRACKING, samples).collect(tree::head)
            }

            spec.isCamera -> codec(spec, values)?.let { ImageEncoder(spec, it) }.use { encoder ->
                val images = adaptation.stream(spec.id)
                val video = video(spec, values, channels, images)
                CameraPipeline(spec, channels, stamps, tree, frameIds, images, encoder, video, report).run(samples)
            }

            spec == StreamTable.controller || spec == StreamTable.markers -> {
                val seen = samples.onEach {
                    if (it is PoseSample) tree.controller(it)
                    if (it is MarkersSample) tree.markers(it)
                }
                MeasurementPipeline(spec, values, channels.single(), stamps, frameIds).run(seen)
            }

            spec == StreamTable.map -> MapPipeline(
                values,
                channels.single(),
                stamps,
                tree,
                frameIds,
                conditions,
                report,
            ).run(samples)

            spec == StreamTable.gaze -> {
                val seen = conditions.watch(Conditions.GAZE, samples)
                MeasurementPipeline(spec, values, channels.single(), stamps, frameIds).run(seen)
            }

            else -> MeasurementPipeline(spec, values, channels.single(), stamps, frameIds).run(samples)
        }
    }

    private fun video(
        spec: StreamSpec,
        values: StreamValues,
        channels: List<TopicChannel>,
        images: AdaptedStream,
    ): VideoStream? {
        val settings = values.video() ?: return null
        val channel = channels.first { it.topic.role == ImageSample.IMAGE }
        return VideoStream(spec, checkNotNull(videoEncoders), settings, TopicVideoChannel(channel, images))
    }

    companion object {
        /** Returns what the images of a camera have by [values]; null for other streams. */
        fun imageSetting(spec: StreamSpec, values: StreamValues): ImageSetting? {
            if (!spec.isCamera) return null
            val rateHz = values.rateHz ?: spec.modes.first().rates.first()
            return ImageSetting(rateHz, values.quality.takeIf { codec(spec, values) == ImageCodec.GREY_JPEG })
        }

        /** Returns what compresses the images of [spec]; null if the source delivers them as they are sent. */
        private fun codec(spec: StreamSpec, values: StreamValues): ImageCodec? =
            spec.topics(values).firstNotNullOfOrNull { ImageCodec.of(it.encoding) }
    }
}

/** The way of a video through [channel]. */
private class TopicVideoChannel(private val channel: TopicChannel, private val images: AdaptedStream) : VideoChannel {
    override val droppedPackets: Long get() = channel.counters.discarded

    override fun admits(captureNanos: Long): Boolean = images.admits(captureNanos)

    override fun refusal(images: Int): DropReason? = when {
        !channel.lane.isOpen -> DropReason.LINK_DOWN
        images < channel.lane.spec.queueFrames -> null
        else -> DropReason.QUEUE_FULL.also { channel.lane.countUnmade() }
    }
}
