package dev.ml2sensors.android

import android.media.Image
import dev.ml2sensors.capture.Slot
import dev.ml2sensors.capture.SlotPool
import dev.ml2sensors.source.DropReason
import dev.ml2sensors.source.SourceException
import java.nio.ByteBuffer
import java.util.concurrent.ArrayBlockingQueue

/** Copies images out of the camera's memory, so that the camera never waits for the encoder. */
internal interface ImageCopier {
    /**
     * Copies [image], which the caller then closes. Returns null and reports the loss if no memory is free. Called by
     * one thread only.
     */
    fun copy(image: Image): CopiedImage?
}

/** A copied image that becomes a JPEG in [slot], or stays as it is there. One call of [encode] or [discard] ends it. */
internal interface CopiedImage {
    val slot: Slot

    /**
     * Encodes, which takes long. Returns true if the image fits into [slot], whose bytes it then is; the caller releases
     * [slot] in any case.
     *
     * @throws SourceException if the encoder fails.
     */
    fun encode(): Boolean

    /** Discards the image and releases its memory. */
    fun discard()
}

/** Copies JPEGs that the camera encoded into slots of [mostBytes]. */
internal class JpegCopier(
    private val pool: SlotPool,
    private val mostBytes: Int,
    private val lose: (DropReason) -> Unit,
) : ImageCopier {
    override fun copy(image: Image): CopiedImage? {
        val source = image.planes.single().buffer
        val slot = pool.take(mostBytes) ?: return null.also { lose(DropReason.NO_BUFFER) }
        val fits = source.remaining() <= mostBytes
        if (fits) slot.bytes.put(source).flip()
        return Whole(slot, fits)
    }
}

/** An image that needs no encoding; [fits] is false if it is larger than [slot]. */
private class Whole(override val slot: Slot, private val fits: Boolean = true) : CopiedImage {
    override fun encode() = fits

    override fun discard() = slot.release()
}

/** Copies YUV_420_888 images as NV21 into slots, for video. */
internal class RawCopier(
    width: Int,
    height: Int,
    private val pool: SlotPool,
    private val lose: (DropReason) -> Unit,
) : ImageCopier {
    private val nv21 = Nv21(width, height)

    override fun copy(image: Image): CopiedImage? {
        val slot = pool.take(nv21.sizeBytes) ?: return null.also { lose(DropReason.NO_BUFFER) }
        try {
            nv21.copy(image.planes, slot.bytes)
        } catch (e: RuntimeException) {
            slot.release()
            throw e
        }
        slot.bytes.flip()
        return Whole(slot)
    }
}

/**
 * Copies YUV_420_888 images, which [encoder] encodes into slots of [mostBytes] on [workers] threads at a time. The
 * copies are in Java's heap, where Android's encoder wants them: `workers + 1` of 1.5 bytes per pixel, allocated here.
 */
internal class YuvCopier(
    private val width: Int,
    private val height: Int,
    private val encoder: JpegEncoder,
    workers: Int,
    private val pool: SlotPool,
    private val mostBytes: Int,
    private val lose: (DropReason) -> Unit,
) : ImageCopier {
    private val nv21 = Nv21(width, height)

    /** One array for each worker, and one that waits for a worker. */
    private val free = ArrayBlockingQueue<ByteArray>(workers + 1)

    init {
        repeat(workers + 1) { free.add(ByteArray(nv21.sizeBytes)) }
    }

    override fun copy(image: Image): CopiedImage? {
        val pixels = free.poll() ?: return null.also { lose(DropReason.ENCODER_BUSY) }
        val slot = pool.take(mostBytes)
        if (slot == null) {
            free.add(pixels)
            lose(DropReason.NO_BUFFER)
            return null
        }
        val copied = Encoding(pixels, slot)
        try {
            nv21.copy(image.planes, ByteBuffer.wrap(pixels))
        } catch (e: RuntimeException) {
            copied.discard()
            throw e
        }
        return copied
    }

    private inner class Encoding(private val pixels: ByteArray, override val slot: Slot) : CopiedImage {
        override fun encode(): Boolean {
            val stream = ByteBufferOutputStream(slot.bytes)
            val isEncoded = try {
                encoder.encode(pixels, width, height, stream)
            } finally {
                free.add(pixels)
            }
            if (!isEncoded) throw SourceException(ENCODING_FAILED)
            slot.bytes.flip()
            return !stream.hasOverflowed
        }

        override fun discard() {
            free.add(pixels)
            slot.release()
        }
    }
}
