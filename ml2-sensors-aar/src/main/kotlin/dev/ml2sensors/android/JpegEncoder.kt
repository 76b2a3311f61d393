package dev.ml2sensors.android

import android.graphics.ImageFormat
import android.graphics.Rect
import android.graphics.YuvImage
import dev.ml2sensors.source.SourceException
import java.io.OutputStream
import java.nio.ByteBuffer

/** Encodes NV21 images as JPEG. Called by several threads. */
internal fun interface JpegEncoder {
    /** Returns true if the platform encoded the image into [target]. */
    fun encode(nv21: ByteArray, width: Int, height: Int, target: OutputStream): Boolean

    companion object {
        const val QUALITY = 90

        val ANDROID: JpegEncoder = JpegEncoder { nv21, width, height, target ->
            YuvImage(nv21, ImageFormat.NV21, width, height, null)
                .compressToJpeg(Rect(0, 0, width, height), QUALITY, target)
        }
    }
}

/** Writes into [target] while there is room, and drops the rest: Android swallows exceptions here. */
internal class ByteBufferOutputStream(private val target: ByteBuffer) : OutputStream() {
    var hasOverflowed: Boolean = false
        private set

    override fun write(byte: Int): Unit = write(byteArrayOf(byte.toByte()))

    override fun write(bytes: ByteArray, offset: Int, length: Int) {
        hasOverflowed = hasOverflowed || length > target.remaining()
        if (!hasOverflowed) target.put(bytes, offset, length)
    }
}

/** Measures once how fast [encoder] is on this device, with a picture of more detail than most. */
internal class EncoderSpeed(private val encoder: JpegEncoder, private val nowNanos: () -> Long = System::nanoTime) {
    /** Without a lock, which would be held while the encoder is awaited. */
    private val pixelsPerSecond by lazy(LazyThreadSafetyMode.PUBLICATION) {
        val picture = ByteArray(WIDTH * HEIGHT * 3 / 2) { ((it * it / 7) % 251).toByte() }
        WIDTH * HEIGHT * 1e9 / List(RUNS) { encodeNanos(picture) }.min().coerceAtLeast(1)
    }

    /** Returns how many images of this size [workers] threads encode per second. */
    fun rateHz(width: Int, height: Int, workers: Int): Double = workers * pixelsPerSecond / (width * height)

    private fun encodeNanos(picture: ByteArray): Long {
        val start = nowNanos()
        val target = ByteBufferOutputStream(ByteBuffer.allocate(WIDTH * HEIGHT * 2))
        if (!encoder.encode(picture, WIDTH, HEIGHT, target)) throw SourceException(ENCODING_FAILED)
        return nowNanos() - start
    }

    private companion object {
        const val WIDTH = 640
        const val HEIGHT = 480
        const val RUNS = 3
    }
}

internal const val ENCODING_FAILED = "Android failed to encode a JPEG"
