package dev.ml2sensors.capture

import dev.ml2sensors.source.DropReason
import dev.ml2sensors.source.ImageSample
import dev.ml2sensors.source.LostSamples
import dev.ml2sensors.source.Sample
import dev.ml2sensors.source.SourceException
import dev.ml2sensors.source.VideoEncoder
import dev.ml2sensors.source.VideoEncoders
import dev.ml2sensors.source.VideoOutput
import dev.ml2sensors.source.VideoPacket
import dev.ml2sensors.source.VideoSettings
import dev.ml2sensors.source.isKeyFrame
import dev.ml2sensors.table.StreamSpec
import kotlinx.coroutines.coroutineScope
import kotlinx.coroutines.flow.Flow
import kotlinx.coroutines.flow.flow
import kotlinx.coroutines.launch
import java.util.concurrent.atomic.AtomicInteger

/** The way of a video's packets after the encoder. Thread-safe. */
internal interface VideoChannel {
    /** The number of packets dropped so far. */
    val droppedPackets: Long

    /** Returns true if the present rate has room for the capture at [captureNanos]. Called once for each. */
    fun admits(captureNanos: Long): Boolean

    /**
     * Returns why no image can be encoded now, while [images] are being encoded or wait to be sent; null if one can. An
     * image that is refused harms no other, but a packet that is dropped does.
     */
    fun refusal(images: Int): DropReason?
}

/**
 * Turns the images of one [stream] into H.264. Packets get slots of their own, as large as the raw image, of which only
 * those pages take memory that a packet reached.
 *
 * Images are left out before they are encoded when the link cannot take them. When a packet gets lost nevertheless, those
 * after it are dropped until the next key frame, which is asked for. There is a key frame each second.
 */
internal class VideoStream(
    private val stream: StreamSpec,
    private val encoders: VideoEncoders,
    private val settings: VideoSettings,
    private val channel: VideoChannel,
) {
    /**
     * Returns the encoded [samples]: each image has the access unit in place of its pixels, and the time, pose and
     * intrinsics of its capture. Losses are passed on. Fails if [samples] or the encoder do.
     */
    fun encoded(samples: Flow<Sample>): Flow<Sample> = flow {
        val queue = SampleQueue(SlotPool.SLOTS)
        coroutineScope {
            val encoding = launch { queue.closeAfter { Encoding(queue).use { it.run(samples) } } }
            try {
                queue.deliverTo(this@flow)
            } finally {
                encoding.cancel()
            }
        }
    }

    /** One run of an encoder. */
    private inner class Encoding(private val queue: SampleQueue) :
        VideoOutput,
        AutoCloseable {
        /** A capture that is being encoded. */
        private inner class Image(val sample: ImageSample) {
            val presentationMicros = sample.captureNanos / NANOS_PER_MICRO
        }

        private val slots = SlotPool(stream, isEncoded = true)
        private val encoder: VideoEncoder

        /** The number of images that are being encoded or wait to be sent. */
        private val images = AtomicInteger()
        private var lastCaptureNanos = Long.MIN_VALUE

        // Below: of whoever holds the lock of this
        private val encoding = ArrayDeque<Image>()
        private var droppedPackets = channel.droppedPackets
        private var awaitsKeyFrame = true
        private var keyFrameNanos = Long.MIN_VALUE

        init {
            try {
                encoder = encoders.open(settings, this)
            } catch (e: Throwable) {
                slots.close()
                throw e
            }
        }

        suspend fun run(samples: Flow<Sample>) = samples.collect { sample ->
            when (sample) {
                is ImageSample -> encode(sample)
                is LostSamples -> queue.countLost(sample.count, sample.reason)
                else -> error("$stream is a camera, but delivered $sample")
            }
        }

        private fun encode(sample: ImageSample) {
            if (!channel.admits(sample.captureNanos)) return
            val refusal =
                channel.refusal(images.get()) ?: DropReason.UNUSABLE.takeIf { sample.captureNanos <= lastCaptureNanos }
            if (refusal != null) return queue.countLost(1, refusal)
            lastCaptureNanos = sample.captureNanos
            val image = Image(sample)
            val asKeyFrame = begin(image)
            if (encoder.encode(sample, image.presentationMicros, asKeyFrame)) return
            takeBack(image, asKeyFrame)
            queue.countLost(1, DropReason.ENCODER_BUSY)
        }

        /** Notes that [image] is being encoded; returns true if it must be a key frame. */
        @Synchronized
        private fun begin(image: Image): Boolean {
            noteDropped()
            images.incrementAndGet()
            encoding += image
            val captureNanos = image.sample.captureNanos
            val isDue = keyFrameNanos == Long.MIN_VALUE || captureNanos - keyFrameNanos >= KEY_FRAME_NANOS
            if (isDue) keyFrameNanos = captureNanos
            return isDue
        }

        @Synchronized
        private fun takeBack(image: Image, wasKeyFrame: Boolean) {
            encoding.remove(image)
            images.decrementAndGet()
            if (wasKeyFrame) keyFrameNanos = Long.MIN_VALUE
        }

        private fun noteDropped() {
            val dropped = channel.droppedPackets
            if (dropped != droppedPackets) awaitKeyFrame()
            droppedPackets = dropped
        }

        private fun awaitKeyFrame() {
            awaitsKeyFrame = true
            keyFrameNanos = Long.MIN_VALUE
        }

        override fun packet(packet: VideoPacket) {
            val image = ended(packet)
            if (image == null) {
                failed(SourceException("the encoder of $stream returned an image that it was not given"))
                return
            }
            val lost = publish(packet, image.sample) ?: return
            images.decrementAndGet()
            queue.countLost(1, lost)
        }

        /** Returns the image of [packet]; counts those before it that the encoder left out. */
        @Synchronized
        private fun ended(packet: VideoPacket): Image? {
            while (true) {
                val image = encoding.removeFirstOrNull() ?: return null
                if (image.presentationMicros == packet.presentationMicros) return image
                images.decrementAndGet()
                queue.countLost(1, DropReason.ENCODER_BUSY)
            }
        }

        /** Returns why [packet] cannot be used, null if it can. */
        @Synchronized
        private fun publish(packet: VideoPacket, sample: ImageSample): DropReason? {
            noteDropped()
            val isKeyFrame = packet.bytes.isKeyFrame()
            if (awaitsKeyFrame && !isKeyFrame) return DropReason.AWAITING_KEY_FRAME
            val slot = slots.take(settings.width * settings.height)
            if (slot == null || packet.bytes.remaining() > slot.bytes.remaining()) {
                awaitKeyFrame()
                slot?.release() ?: return DropReason.NO_BUFFER
                return DropReason.UNUSABLE
            }
            awaitsKeyFrame = false
            slot.bytes.put(packet.bytes).flip()
            queue.offer(sample.withPacket(slot))
            return null
        }

        private fun ImageSample.withPacket(slot: Slot) = ImageSample(
            captureNanos,
            frameNumber,
            width,
            height,
            strideBytes = 0,
            pose,
            intrinsics,
            metadata,
            listOf(ImageSample.Plane(ImageSample.IMAGE, slot.bytes)),
            giveBack = {
                slot.release()
                images.decrementAndGet()
            },
        )

        override fun failed(cause: Exception): Unit = queue.close(cause)

        override fun close() {
            encoder.close()
            slots.close()
        }
    }

    companion object {
        /** In metadata. */
        const val CODEC: String = "h264"
        private const val NANOS_PER_MICRO = 1000

        /** The time from one key frame to the next. */
        private const val KEY_FRAME_NANOS = 1_000_000_000L
    }
}
