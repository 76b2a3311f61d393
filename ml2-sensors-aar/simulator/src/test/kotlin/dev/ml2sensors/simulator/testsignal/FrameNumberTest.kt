package dev.ml2sensors.simulator.testsignal

import org.junit.jupiter.api.Test
import java.awt.image.BufferedImage
import java.io.ByteArrayOutputStream
import java.nio.ByteBuffer
import java.nio.ByteOrder
import javax.imageio.ImageIO
import kotlin.test.assertContentEquals
import kotlin.test.assertEquals

class FrameNumberTest {
    private val image = ByteBuffer.allocateDirect(1024).order(ByteOrder.LITTLE_ENDIAN)

    @Test
    fun mono8PixelsAreTheBitsOfTheNumber() {
        FrameNumber.MONO8.write(image, 0x8000_0005)
        val expected = ByteArray(32).also {
            it[0] = -1
            it[29] = -1
            it[31] = -1
        }
        assertContentEquals(expected, bytes(32))
    }

    @Test
    fun floatPixelsAreLittleEndianOnesAndZeros() {
        FrameNumber.FLOAT32.write(image, 2)
        val one = byteArrayOf(0, 0, 0x80.toByte(), 0x3f)
        assertContentEquals(ByteArray(30 * 4) + one + ByteArray(4), bytes(128))
    }

    @Test
    fun integerPixelsAreLittleEndianOnesAndZeros() {
        FrameNumber.INT32.write(image, 1)
        assertContentEquals(ByteArray(31 * 4) + byteArrayOf(1, 0, 0, 0), bytes(128))
    }

    @Test
    fun rawNumbersStartAgainAt2To32() {
        FrameNumber.MONO8.write(image, 0x1_0000_0000)
        assertContentEquals(ByteArray(32), bytes(32))
    }

    @Test
    fun onlyTheFirst32PixelsAreTouched() {
        for (index in 0 until image.capacity()) image.put(index, 0x55)
        FrameNumber.FLOAT32.write(image, 77)
        assertEquals(setOf<Byte>(0x55), bytes(image.capacity()).drop(128).toSet())
    }

    @Test
    fun jpegHasTheNumberInACommentAndDecodesAsBefore() {
        val plain = ByteArrayOutputStream().also { ImageIO.write(BufferedImage(64, 48, 1), "jpeg", it) }.toByteArray()
        val marked = ByteBuffer.wrap(FrameNumber.withComment(plain))
        FrameNumber.JPEG.write(marked, 4_711)
        FrameNumber.JPEG.write(marked, 42)
        val comment = byteArrayOf(-1, -2, 0, 18) + "frame=0000000042".toByteArray()
        assertContentEquals(plain.copyOf(20) + comment, marked.array().copyOf(40))
        assertContentEquals(plain.drop(20), marked.array().drop(40))
        val reader = ImageIO.getImageReadersByFormatName("jpeg").next()
        reader.input = ImageIO.createImageInputStream(marked.array().inputStream())
        val comments = reader.getImageMetadata(0).getAsTree("javax_imageio_jpeg_image_1.0")
        assertEquals(64 to 48, reader.getWidth(0) to reader.getHeight(0))
        assertEquals("frame=0000000042", comments.find("com")?.getNamedItem("comment")?.nodeValue)
    }

    private fun bytes(count: Int) = ByteArray(count).also { image.duplicate().get(it) }
}

private fun org.w3c.dom.Node.find(name: String): org.w3c.dom.NamedNodeMap? {
    if (nodeName == name) return attributes
    return (0 until childNodes.length).firstNotNullOfOrNull { childNodes.item(it).find(name) }
}
