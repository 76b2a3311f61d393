package dev.ml2sensors.android

import android.media.Image
import dev.ml2sensors.source.BufferPool
import dev.ml2sensors.source.DropReason
import dev.ml2sensors.source.SourceException
import java.nio.ByteBuffer
import java.util.concurrent.ArrayBlockingQueue

/** Copies images out of the camera's memory, so that the camera never waits for what is done with them. */
internal interface ImageCopier {
    /** The caller then closes [image]. Null where there is no memory for it, which is told. Only by one thread. */
    fun take(image: Image): CopiedImage?
}

/** An image on its way to become [jpeg], memory of a pool; ended by one call of [finish] or [giveUp]. */
internal interface CopiedImage {
    val jpeg: ByteBuffer

    /** Whether all of the JPEG found room in [jpeg], which the caller gives back in any case. Takes long. */
    fun finish(): Boolean

    /** Gives everything back. */
    fun giveUp()
}

/** Images that the camera itself makes JPEGs of: one copy into [pool]. */
internal class JpegCopier(private val pool: BufferPool, private val lose: (DropReason) -> Unit) : ImageCopier {
    override fun take(image: Image): CopiedImage? {
        val jpeg = pool.acquire() ?: return null.also { lose(DropReason.NO_BUFFER) }
        val source = image.planes.single().buffer
        val fits = source.remaining() <= jpeg.remaining()
        if (fits) jpeg.put(source).flip()
        return object : CopiedImage {
            override val jpeg = jpeg

            override fun finish() = fits

            override fun giveUp() = pool.giveBack(jpeg)
        }
    }
}

/** YUV_420_888 images, of which [encoder] makes JPEGs in [pool] on [workers] threads at a time. */
internal class YuvCopier(
    private val width: Int,
    private val height: Int,
    private val encoder: JpegEncoder,
    workers: Int,
    private val pool: BufferPool,
    private val lose: (DropReason) -> Unit,
) : ImageCopier {
    private val nv21 = Nv21(width, height)

    /** One that each worker has, and one that waits for a worker. */
    private val free = ArrayBlockingQueue<ByteArray>(workers + 1)

    init {
        repeat(workers + 1) { free.add(ByteArray(nv21.sizeBytes)) }
    }

    override fun take(image: Image): CopiedImage? {
        val pixels = free.poll() ?: return null.also { lose(DropReason.ENCODER_BUSY) }
        val jpeg = pool.acquire()
        if (jpeg == null) {
            free.add(pixels)
            lose(DropReason.NO_BUFFER)
            return null
        }
        nv21.copy(image.planes, pixels)
        return Encoding(pixels, jpeg)
    }

    private inner class Encoding(private val pixels: ByteArray, override val jpeg: ByteBuffer) : CopiedImage {
        override fun finish(): Boolean {
            val stream = ByteBufferOutputStream(jpeg)
            val isEncoded = encoder.encode(pixels, width, height, stream)
            free.add(pixels)
            if (!isEncoded) throw SourceException(ENCODING_FAILED)
            jpeg.flip()
            return !stream.hasOverflowed
        }

        override fun giveUp() {
            free.add(pixels)
            pool.giveBack(jpeg)
        }
    }
}
