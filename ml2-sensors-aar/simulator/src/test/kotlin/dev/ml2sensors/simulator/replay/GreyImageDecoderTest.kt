package dev.ml2sensors.simulator.replay

import org.junit.jupiter.api.io.TempDir
import java.awt.Color
import java.awt.image.BufferedImage
import java.io.File
import java.nio.ByteBuffer
import javax.imageio.ImageIO
import kotlin.random.Random
import kotlin.test.Test
import kotlin.test.assertContentEquals
import kotlin.test.assertEquals
import kotlin.test.assertFailsWith
import kotlin.test.assertTrue

class GreyImageDecoderTest {
    @TempDir
    lateinit var folder: File

    private val decoder = GreyImageDecoder(16, 8)
    private val pixels = Random(3).nextBytes(16 * 8)
    private val file by lazy { folder.resolve("image.png").also { SyntheticRecording.writePng(it, pixels, 16) } }

    @Test
    fun pixelsAreThoseOfTheFile() {
        val target = ByteBuffer.allocateDirect(16 * 8)
        decoder.decode(file, target)
        assertContentEquals(pixels, ByteArray(16 * 8).also { target.flip().get(it) })
    }

    @Test
    fun otherPixelFormatsAreConverted() {
        val red = 0xFF8040
        for ((type, words) in listOf(
            BufferedImage.TYPE_3BYTE_BGR to "8-bit colour",
            BufferedImage.TYPE_4BYTE_ABGR to "8-bit colour",
            BufferedImage.TYPE_BYTE_INDEXED to "indexed colour",
            BufferedImage.TYPE_BYTE_BINARY to "indexed colour",
        )) {
            val image = BufferedImage(16, 8, type)
            for (y in 0 until 8) for (x in 0 until 16) image.setRGB(x, y, if (x < 8) red else 0xFFFFFF)
            ImageIO.write(image, "png", file)
            // The palettes of indexed images hold other colours; 0.299 R + 0.587 G + 0.114 B of what was stored
            val stored = Color(image.getRGB(0, 0))
            val luma = 0.299 * stored.red + 0.587 * stored.green + 0.114 * stored.blue
            val found = decode()
            assertEquals(luma, (found[0].toInt() and 255).toDouble(), 0.51, "$type")
            assertEquals(255, found[15].toInt() and 255, "$type")
            assertEquals(words, decoder.otherFormat(file))
        }
    }

    @Test
    fun sixteenBitsGiveTheirUpperEight() {
        val image = BufferedImage(16, 8, BufferedImage.TYPE_USHORT_GRAY)
        for (at in 0 until 128) image.raster.setSample(at % 16, at / 16, 0, at * 512 + 255)
        ImageIO.write(image, "png", file)
        assertEquals(List(128) { it * 2 }, decode().map { it.toInt() and 255 })
        assertEquals("16-bit grey", decoder.otherFormat(file))
    }

    @Test
    fun jpegIsDecoded() {
        val image = BufferedImage(16, 8, BufferedImage.TYPE_BYTE_GRAY)
        for (at in 0 until 128) image.raster.setSample(at % 16, at / 16, 0, 100)
        ImageIO.write(image, "jpg", file)
        assertTrue(decode().all { it in 98..102 })
    }

    @Test
    fun otherFilesAreRefused() {
        ImageIO.write(BufferedImage(16, 8, BufferedImage.TYPE_BYTE_GRAY), "bmp", file)
        val failure = failure()
        assertEquals("a PNG or JPEG image" to "another format", failure.expected to failure.found)
    }

    @Test
    fun otherSizesAreRefused() {
        SyntheticRecording.writePng(file, pixels, 8)
        val failure = failure()
        assertEquals("16x8 pixels", failure.expected)
        assertEquals("8x16", failure.found)
    }

    @Test
    fun everyTruncatedFileGivesARecordingException() {
        val whole = file.readBytes()
        val end = whole.size - 12
        for (size in 0 until end) {
            file.writeBytes(whole.copyOf(size))
            failure()
        }
    }

    @Test
    fun randomDamageGivesAnImageOrARecordingException() {
        val whole = file.readBytes()
        val random = Random(5)
        var failures = 0
        repeat(2000) {
            val bytes = whole.copyOf()
            repeat(3) { bytes[random.nextInt(bytes.size)] = random.nextBytes(1)[0] }
            file.writeBytes(bytes)
            try {
                decoder.decode(file, ByteBuffer.allocate(16 * 8))
            } catch (_: RecordingException) {
                failures++
            }
        }
        assertTrue(failures > 500, "$failures")
    }

    private fun decode() = ByteBuffer.allocate(16 * 8).also { decoder.decode(file, it) }.array()

    private fun failure(): RecordingException {
        val failure = assertFailsWith<RecordingException> { decoder.decode(file, ByteBuffer.allocate(16 * 8)) }
        assertEquals(file, failure.file)
        return failure
    }
}
