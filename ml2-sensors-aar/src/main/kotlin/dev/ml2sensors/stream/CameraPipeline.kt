package dev.ml2sensors.stream

import dev.ml2sensors.capture.ImageEncoder
import dev.ml2sensors.capture.VideoStream
import dev.ml2sensors.clock.StampMap
import dev.ml2sensors.message.CameraInfo
import dev.ml2sensors.message.CompressedImage
import dev.ml2sensors.message.CompressedVideo
import dev.ml2sensors.message.FfmpegPacket
import dev.ml2sensors.message.Header
import dev.ml2sensors.message.Image
import dev.ml2sensors.message.StringMessage
import dev.ml2sensors.message.Time
import dev.ml2sensors.message.rosType
import dev.ml2sensors.pacing.AdaptedStream
import dev.ml2sensors.pacing.ImageSetting
import dev.ml2sensors.source.DropReason
import dev.ml2sensors.source.ImageSample
import dev.ml2sensors.source.LostSamples
import dev.ml2sensors.source.RosCamera
import dev.ml2sensors.source.Sample
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable
import dev.ml2sensors.wire.Event
import kotlinx.coroutines.flow.Flow
import kotlinx.coroutines.flow.onEach

/**
 * Publishes a camera stream: gives each capture one stamp, sends its pose, compresses the image if its topic is
 * compressed, and sends image, camera_info and metadata.
 *
 * @param channels of the enabled topics.
 * @param tree receives the poses.
 * @param images says which captures are published, and with what quality.
 * @param encoder compresses the images of the source; null if they are sent as they are, or as [video].
 * @param video makes them a video, and then says which are published; null for all other formats.
 * @param report receives how many colour images had no pose. The poses of other cameras end with the head's alone,
 * which has events of its own.
 */
internal class CameraPipeline(
    private val spec: StreamSpec,
    private val channels: List<TopicChannel>,
    private val stamps: StampMap,
    private val tree: TransformTree,
    private val frameIds: FrameIds,
    private val images: AdaptedStream,
    private val encoder: ImageEncoder? = null,
    private val video: VideoStream? = null,
    report: (Event) -> Unit = {},
) {
    private val poseless =
        if (spec.bodyFrameId == StreamTable.color.bodyFrameId) PoselessImages(spec, report) else null
    private var camera: RosCamera? = null
    private val parts = channels.map(::part)

    /** One image, as all topics have it. */
    private class Capture(val sample: ImageSample, val header: Header, val stampNanos: Long, val quality: Int?)

    /** Runs until [samples] end or fail. */
    suspend fun run(samples: Flow<Sample>) {
        val captures = samples.onEach { if (it is ImageSample) addPose(it) }
        try {
            (video?.encoded(captures) ?: captures).collect { sample ->
                when (sample) {
                    is ImageSample -> stamp(sample)
                    is LostSamples -> lose(sample.count, sample.reason)
                    else -> error("$spec is a camera, but delivered $sample")
                }
            }
        } finally {
            poseless?.end()
        }
    }

    /** Publishes an image with its stamp, unless it has none or gives way to the link. */
    private suspend fun stamp(sample: ImageSample) {
        val stampNanos = stamps.stampNanos(sample.captureNanos)
        val setting = images.present
        when {
            stampNanos == null -> lose(1, stamps.lossReason(sample.captureNanos))
            video == null && !images.admits(sample.captureNanos) -> Unit
            encoder == null -> publishCapture(sample, stampNanos, setting)
            else -> compress(encoder, sample, stampNanos, setting)
        }
    }

    private suspend fun addPose(sample: ImageSample) {
        poseless?.add(hasPose = sample.pose != null)
        if (spec.bodyFrameId == null) return
        sample.pose?.let { tree.camera(spec, sample.captureNanos, stamps.stampNanos(sample.captureNanos), it) }
    }

    private fun lose(count: Int, reason: DropReason) = channels.forEach { it.counters.countLost(count, reason) }

    private suspend fun compress(
        encoder: ImageEncoder,
        sample: ImageSample,
        stampNanos: Long,
        setting: ImageSetting,
    ) {
        val compressed = encoder.encode(sample, setting.quality ?: 0) ?: return lose(1, DropReason.NO_BUFFER)
        try {
            publishCapture(compressed, stampNanos, setting)
        } finally {
            compressed.release()
        }
    }

    private suspend fun publishCapture(sample: ImageSample, stampNanos: Long, setting: ImageSetting) {
        val capture = Capture(sample, Header(Time.ofNanos(stampNanos), frameIds.of(spec)), stampNanos, setting.quality)
        images.published(channels.sumOf { sample.plane(it.topic.role)?.remaining() ?: 0 }, setting)
        for (publishPart in parts) publishPart(capture)
    }

    /** Returns the function that publishes a channel's part of a capture. */
    private fun part(channel: TopicChannel): suspend (Capture) -> Unit {
        val topic = channel.topic
        val encoding = topic.encoding ?: spec.encoding
        return when (topic.type) {
            Image.serializer().rosType -> { it ->
                it.sample.plane(topic.role)?.let { pixels ->
                    val image = it.sample.toImage(it.header, checkNotNull(encoding), pixels)
                    channel.publish(Image.serializer(), image, it.stampNanos, it.sample)
                }
            }

            CompressedImage.serializer().rosType -> { it ->
                val image = it.sample.toCompressedImage(it.header, checkNotNull(encoding))
                channel.publish(CompressedImage.serializer(), image, it.stampNanos, it.sample)
            }

            FfmpegPacket.serializer().rosType -> { it ->
                val packet = it.sample.toFfmpegPacket(it.header, checkNotNull(encoding))
                channel.publish(FfmpegPacket.serializer(), packet, it.stampNanos, it.sample)
            }

            CompressedVideo.serializer().rosType -> { it ->
                val image = it.sample.toCompressedVideo(it.header, checkNotNull(encoding))
                channel.publish(CompressedVideo.serializer(), image, it.stampNanos, it.sample)
            }

            CameraInfo.serializer().rosType -> { it ->
                camera(it.sample)?.let { camera ->
                    channel.publish(CameraInfo.serializer(), camera.toCameraInfo(it.header), it.stampNanos)
                }
            }

            StringMessage.serializer().rosType -> { it ->
                channel.publish(StringMessage.serializer(), metadata(it.sample, it.header, it.quality), it.stampNanos)
            }

            else -> error("no camera publishes ${topic.type}")
        }
    }

    private fun metadata(sample: ImageSample, header: Header, quality: Int?) =
        sample.toMetadata(
            header,
            camera(sample),
            if (video == null) encoder?.codec?.title else VideoStream.CODEC,
            quality,
        )

    /** Returns the camera in a ROS model; fits it only when the device's intrinsics change. */
    private fun camera(sample: ImageSample): RosCamera? {
        if (camera?.device != sample.intrinsics) camera = sample.intrinsics?.let(::RosCamera)
        return camera
    }
}
