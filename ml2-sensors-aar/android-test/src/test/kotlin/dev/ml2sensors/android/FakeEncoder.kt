package dev.ml2sensors.android

import java.io.OutputStream
import java.util.concurrent.CountDownLatch
import java.util.concurrent.Semaphore
import java.util.zip.CRC32

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
