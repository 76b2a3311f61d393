package dev.ml2sensors.android

import android.media.Image
import dev.ml2sensors.capture.Slot
import dev.ml2sensors.capture.SlotPool
import dev.ml2sensors.source.DropReason
import dev.ml2sensors.source.SourceException
import java.util.concurrent.ArrayBlockingQueue

/** Copies images out of the camera's memory, so that the camera never waits for the encoder. */
internal interface ImageCopier {
    /**
     * Copies [image], which the caller then closes. Returns null and reports the loss if no memory is free. Called by
     * one thread only.
     */
    fun copy(image: Image): CopiedImage?
}

/** A copied image that becomes a JPEG in the slot [jpeg]. One call of [encode] or [discard] ends it. */
internal interface CopiedImage {
    val jpeg: Slot

    /**
     * Encodes, which takes long. Returns true if the JPEG fits into [jpeg], whose bytes it then is; the caller releases
     * [jpeg] in any case.
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
        val jpeg = pool.take(mostBytes) ?: return null.also { lose(DropReason.NO_BUFFER) }
        val fits = source.remaining() <= mostBytes
        if (fits) jpeg.bytes.put(source).flip()
        return object : CopiedImage {
            override val jpeg = jpeg

            override fun encode() = fits

            override fun discard() = jpeg.release()
        }
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
        val jpeg = pool.take(mostBytes)
        if (jpeg == null) {
            free.add(pixels)
            lose(DropReason.NO_BUFFER)
            return null
        }
        val copied = Encoding(pixels, jpeg)
        try {
            nv21.copy(image.planes, pixels)
        } catch (e: RuntimeException) {
            copied.discard()
            throw e
        }
        return copied
    }

    private inner class Encoding(private val pixels: ByteArray, override val jpeg: Slot) : CopiedImage {
        override fun encode(): Boolean {
            val stream = ByteBufferOutputStream(jpeg.bytes)
            val isEncoded = try {
                encoder.encode(pixels, width, height, stream)
            } finally {
                free.add(pixels)
            }
            if (!isEncoded) throw SourceException(ENCODING_FAILED)
            jpeg.bytes.flip()
            return !stream.hasOverflowed
        }

        override fun discard() {
            free.add(pixels)
            jpeg.release()
        }
    }
}
