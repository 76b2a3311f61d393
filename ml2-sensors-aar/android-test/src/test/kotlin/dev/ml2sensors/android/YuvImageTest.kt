package dev.ml2sensors.android

import android.graphics.YuvImage
import org.junit.Test
import org.junit.runner.RunWith
import org.robolectric.RobolectricTestRunner
import org.robolectric.annotation.Config
import org.robolectric.annotation.Implementation
import org.robolectric.annotation.Implements
import java.awt.image.BufferedImage
import java.io.ByteArrayInputStream
import java.io.OutputStream
import java.nio.ByteBuffer
import javax.imageio.ImageIO
import kotlin.random.Random
import kotlin.test.assertContentEquals
import kotlin.test.assertEquals
import kotlin.test.assertFalse
import kotlin.test.assertTrue

/** On Android 10's own YuvImage, with Java's encoder where its native code is. */
@RunWith(RobolectricTestRunner::class)
@Config(sdk = [29], manifest = Config.NONE, shadows = [YuvImageTest.NativeEncoder::class])
class YuvImageTest {
    /** Grey values go to the left, the limits of V and U to the right. */
    private val nv21 = ByteArray(WIDTH * HEIGHT * 3 / 2) {
        if (it <
            WIDTH * HEIGHT
        ) {
            (it % WIDTH * 8).toByte()
        } else {
            0x80.toByte()
        }
    }

    @Test
    fun theJpegShowsTheImage() {
        val target = ByteBuffer.allocateDirect(WIDTH * HEIGHT * 4)
        assertTrue(JpegEncoder.ANDROID.encode(nv21, WIDTH, HEIGHT, ByteBufferOutputStream(target)))
        val bytes = ByteArray(target.flip().remaining()).also(target::get)
        val decoded = ImageIO.read(ByteArrayInputStream(bytes))
        assertEquals(WIDTH to HEIGHT, decoded.width to decoded.height)
        for (x in 0 until WIDTH) assertEquals(x * 8.0, (decoded.getRGB(x, 5) and 0xff).toDouble(), 6.0, "column $x")
    }

    @Test
    fun aJpegThatDoesNotFitIsSaidNotTo() {
        val target = ByteBuffer.allocateDirect(100)
        val stream = ByteBufferOutputStream(target)
        JpegEncoder.ANDROID.encode(nv21, WIDTH, HEIGHT, stream)
        assertTrue(stream.hasOverflowed)
    }

    @Test
    fun whatFitsToTheLastByteHasNotOverflowed() {
        val stream = ByteBufferOutputStream(ByteBuffer.allocate(3))
        stream.write(byteArrayOf(1, 2))
        stream.write(3)
        assertFalse(stream.hasOverflowed)
        stream.write(4)
        assertTrue(stream.hasOverflowed)
    }

    @Implements(YuvImage::class)
    class NativeEncoder {
        companion object {
            @JvmStatic
            @Implementation
            fun nativeCompressToJpeg(
                yuv: ByteArray,
                format: Int,
                width: Int,
                height: Int,
                offsets: IntArray,
                strides: IntArray,
                quality: Int,
                stream: OutputStream,
                chunk: ByteArray,
            ): Boolean {
                val image = BufferedImage(width, height, BufferedImage.TYPE_INT_RGB)
                for (y in 0 until height) {
                    for (x in 0 until width) {
                        val grey = yuv[offsets[0] + y * strides[0] + x].toInt() and 0xff
                        image.setRGB(x, y, grey * 0x010101)
                    }
                }
                return ImageIO.write(image, "jpeg", stream)
            }
        }
    }

    private companion object {
        const val WIDTH = 32
        const val HEIGHT = 16
    }
}

class Nv21Test {
    @Test
    fun anyStridesGiveTheSamePicture() {
        val random = Random(1)
        repeat(500) { round ->
            val picture = Picture(random.nextInt(1, 40), random.nextInt(1, 30), random)
            val nv21 = Nv21(picture.width, picture.height)
            val target = ByteArray(nv21.sizeBytes)
            // The strides may change from one image to the next
            repeat(2) {
                nv21.copy(picture.planes(random), ByteBuffer.wrap(target))
                assertContentEquals(picture.toNv21(), target, "round $round, ${picture.width}x${picture.height}")
            }
        }
    }
}
