package dev.ml2sensors.stream

import dev.ml2sensors.clock.StampMap
import dev.ml2sensors.message.CameraInfo
import dev.ml2sensors.message.CompressedImage
import dev.ml2sensors.message.Header
import dev.ml2sensors.message.Image
import dev.ml2sensors.message.StringMessage
import dev.ml2sensors.message.Time
import dev.ml2sensors.message.rosType
import dev.ml2sensors.source.ImageSample
import dev.ml2sensors.source.LostSamples
import dev.ml2sensors.source.RosCamera
import dev.ml2sensors.source.Sample
import dev.ml2sensors.table.StreamSpec
import kotlinx.coroutines.flow.Flow

/**
 * Publishes a camera stream: gives each capture one stamp and sends image, camera_info, metadata and pose.
 *
 * @param channels of the enabled topics.
 * @param tree receives the poses.
 */
internal class CameraPipeline(
    private val spec: StreamSpec,
    private val channels: List<TopicChannel>,
    private val stamps: StampMap,
    private val tree: TransformTree,
    private val frameIds: FrameIds,
) {
    private var camera: RosCamera? = null

    /** Runs until [samples] end or fail. */
    suspend fun run(samples: Flow<Sample>) {
        samples.collect { sample ->
            when (sample) {
                is ImageSample -> publish(sample)
                is LostSamples -> channels.forEach { it.counters.countLost(sample.count, sample.reason) }
                else -> error("$spec is a camera, but delivered $sample")
            }
        }
    }

    private suspend fun publish(sample: ImageSample) {
        val stampNanos = stamps.stampNanos(sample.captureNanos)
        if (stampNanos == null) {
            channels.forEach { it.counters.countLost(1, stamps.lossReason(sample.captureNanos)) }
        } else {
            val header = Header(Time.ofNanos(stampNanos), frameIds.of(spec))
            for (channel in channels) publish(channel, sample, header, stampNanos)
        }
        if (spec.bodyFrameId != null) sample.pose?.let { tree.camera(spec, sample.captureNanos, stampNanos, it) }
    }

    private suspend fun publish(
        channel: TopicChannel,
        sample: ImageSample,
        header: Header,
        stampNanos: Long,
    ) {
        val topic = channel.topic
        when (topic.type) {
            Image.serializer().rosType -> {
                val pixels = sample.plane(topic.role) ?: return
                val encoding = checkNotNull(topic.encoding ?: spec.encoding) { "$spec has no encoding in the table" }
                channel.publish(Image.serializer(), sample.toImage(header, encoding, pixels), stampNanos, sample)
            }

            CompressedImage.serializer().rosType -> {
                val format = checkNotNull(spec.encoding) { "$spec has no encoding in the table" }
                val message = sample.toCompressedImage(header, format)
                channel.publish(CompressedImage.serializer(), message, stampNanos, sample)
            }

            CameraInfo.serializer().rosType -> {
                val camera = camera(sample) ?: return
                channel.publish(CameraInfo.serializer(), camera.toCameraInfo(header), stampNanos)
            }

            StringMessage.serializer().rosType ->
                channel.publish(StringMessage.serializer(), sample.toMetadata(header, camera(sample)), stampNanos)

            else -> error("no camera publishes ${topic.type}")
        }
    }

    /** Returns the camera in a ROS model; fits it only when the device's intrinsics change. */
    private fun camera(sample: ImageSample): RosCamera? {
        if (camera?.device != sample.intrinsics) camera = sample.intrinsics?.let(::RosCamera)
        return camera
    }
}
