package dev.ml2sensors.android

import android.graphics.ImageFormat
import android.media.Image
import java.io.OutputStream
import java.nio.ByteBuffer
import java.util.concurrent.CountDownLatch
import java.util.concurrent.Semaphore
import java.util.zip.CRC32
import kotlin.random.Random

/** An image in the camera's memory, which cannot be read after it was closed and is closed once. */
internal class FakeImage(
    private val format: Int,
    private val width: Int,
    private val height: Int,
    private val timestamp: Long,
    private val planes: List<FakePlane>,
) : Image() {
    var isClosed = false
        private set

    override fun getFormat() = format

    override fun getWidth() = width

    override fun getHeight() = height

    override fun getTimestamp() = timestamp

    override fun getTransform() = 0

    override fun getScalingMode() = 0

    override fun getPlanes(): Array<Plane> {
        check(!isClosed) { "image $timestamp read after it was closed" }
        return planes.toTypedArray()
    }

    override fun close() {
        check(!isClosed) { "image $timestamp closed twice" }
        isClosed = true
    }

    companion object {
        fun jpeg(timestamp: Long, bytes: ByteArray, width: Int = 640, height: Int = 480) =
            FakeImage(ImageFormat.JPEG, width, height, timestamp, listOf(FakePlane(ByteBuffer.wrap(bytes), 0, 0)))
    }
}

internal class FakePlane(private val bytes: ByteBuffer, private val rowStride: Int, private val pixelStride: Int) :
    Image.Plane() {
    override fun getRowStride() = rowStride

    override fun getPixelStride() = pixelStride

    override fun getBuffer() = bytes
}

/** The content of a picture, independent of its layout in memory: one array per channel, without strides. */
internal class Picture(val width: Int, val height: Int, random: Random) {
    val chromaWidth = (width + 1) / 2
    val chromaHeight = (height + 1) / 2
    val y: ByteArray = random.nextBytes(width * height)
    val u: ByteArray = random.nextBytes(chromaWidth * chromaHeight)
    val v: ByteArray = random.nextBytes(chromaWidth * chromaHeight)

    /** In memory with strides of [random]'s choice, and noise where no pixel is. */
    fun planes(random: Random): Array<Image.Plane> = arrayOf(
        plane(y, width, height, pixelStride = 1, random),
        plane(u, chromaWidth, chromaHeight, random.nextInt(1, 4), random),
        plane(v, chromaWidth, chromaHeight, random.nextInt(1, 4), random),
    )

    fun image(timestamp: Long, random: Random) = FakeImage(
        ImageFormat.YUV_420_888,
        width,
        height,
        timestamp,
        planes(random).map { it as FakePlane },
    )

    /** By definition: all of Y, then V and U of each block of four pixels. */
    fun toNv21(): ByteArray = y + ByteArray(2 * u.size) { if (it % 2 == 0) v[it / 2] else u[it / 2] }

    private fun plane(channel: ByteArray, width: Int, height: Int, pixelStride: Int, random: Random): FakePlane {
        val rowStride = (width - 1) * pixelStride + 1 + random.nextInt(0, 9)
        // Nothing follows the last pixel
        val memory = random.nextBytes((height - 1) * rowStride + (width - 1) * pixelStride + 1)
        for (row in 0 until height) {
            for (column in 0 until width) memory[row * rowStride + column * pixelStride] = channel[row * width + column]
        }
        val buffer = ByteBuffer.allocateDirect(memory.size)
        return FakePlane(buffer.put(memory).flip(), rowStride, pixelStride)
    }
}

/** An encoder whose JPEGs are checksums of the image, and which can be held up. */
internal class FakeEncoder : JpegEncoder {
    @Volatile
    private var held: ByteArray? = null
    private val gate = CountDownLatch(1)
    private val done = Semaphore(0)

    @Volatile
    var fails = false

    /** Images that look like [nv21] are not encoded before [letGo]. */
    fun hold(nv21: ByteArray) {
        held = jpegOf(nv21)
    }

    fun letGo(): Unit = gate.countDown()

    /** Waits until [count] more images have been encoded. */
    fun awaitDone(count: Int): Unit = done.acquire(count)

    override fun encode(nv21: ByteArray, width: Int, height: Int, target: OutputStream): Boolean {
        NeverReturns.pass("YuvImage.compressToJpeg")
        val jpeg = jpegOf(nv21)
        if (jpeg.contentEquals(held)) gate.await()
        target.write(jpeg)
        done.release()
        return !fails
    }

    companion object {
        fun jpegOf(nv21: ByteArray): ByteArray = CRC32().apply { update(nv21) }.value.toString().toByteArray()
    }
}
