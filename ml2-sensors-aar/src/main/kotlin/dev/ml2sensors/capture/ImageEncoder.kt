package dev.ml2sensors.capture

import dev.ml2sensors.source.ImageSample
import dev.ml2sensors.table.StreamSpec

/**
 * A codec for the images of a stream.
 *
 * @property code of ml2s_codec.
 * @property title in metadata.
 * @property encoding of a topic whose images are compressed so, in the stream table.
 */
internal enum class ImageCodec(val code: Int, val title: String, private val encoding: String) {
    /** Grey pixels to a JPEG of one component; quality 1 to 100. */
    GREY_JPEG(1, "jpeg", "mono8; jpeg compressed mono8"),

    /** Depth in metres to millimetres, in the layout of ROS's `16UC1; compressedDepth rvl`; quality 0. */
    DEPTH_RVL(2, "rvl", "16UC1; compressedDepth rvl"),

    ;

    companion object {
        /** Returns the codec that the library applies for a topic with [encoding]; null for all other topics. */
        fun of(encoding: String?): ImageCodec? = entries.firstOrNull { it.encoding == encoding }
    }
}

/**
 * Compresses images of [stream] into slots of its own, so that the latest raw frame is still published. A slot is
 * mapped in the size that no image exceeds, and takes as many pages as its largest image so far had. Slots that are
 * still leased after [close] are freed with their lease.
 */
internal class ImageEncoder(stream: StreamSpec, val codec: ImageCodec) : AutoCloseable {
    private val slots = SlotPool(stream, isEncoded = true)

    /**
     * Returns the image of [sample] compressed, or null if all slots are leased. The result differs from [sample] in
     * its image, its strideBytes, which are 0, and its release, which releases the slot. If [sample] has planes beside
     * the image, the result has them too and retains [sample] until its own release. Does not release [sample].
     * Thread: one at a time.
     *
     * @throws IllegalArgumentException if the image is not in a direct buffer or does not fit [codec] and [quality].
     */
    fun encode(sample: ImageSample, quality: Int): ImageSample? {
        val slot = slots.take(Native.mostEncodedBytes(codec.code, sample.width, sample.height)) ?: return null
        return try {
            encodeInto(slot, sample, quality)
        } catch (e: Throwable) {
            slot.release()
            throw e
        }
    }

    private fun encodeInto(slot: Slot, sample: ImageSample, quality: Int): ImageSample {
        val sizeBytes = with(sample) {
            Native.encode(pixels.slice(), codec.code, quality, width, height, strideBytes, slots.set, slot.index)
        }
        val image = slot.bytes.limit(sizeBytes)
        val others = sample.planesBesideImage
        if (others.isNotEmpty()) sample.retain()
        return ImageSample(
            sample.captureNanos,
            sample.frameNumber,
            sample.width,
            sample.height,
            strideBytes = 0,
            sample.pose,
            sample.intrinsics,
            sample.metadata,
            listOf(ImageSample.Plane(ImageSample.IMAGE, image)) + others,
            giveBack = {
                slot.release()
                if (others.isNotEmpty()) sample.release()
            },
        )
    }

    override fun close(): Unit = slots.close()
}
