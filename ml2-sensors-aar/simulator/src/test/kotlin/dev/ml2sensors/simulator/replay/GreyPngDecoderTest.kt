package dev.ml2sensors.simulator.replay

import org.junit.jupiter.api.io.TempDir
import java.awt.image.BufferedImage
import java.io.File
import java.nio.ByteBuffer
import kotlin.random.Random
import kotlin.test.Test
import kotlin.test.assertContentEquals
import kotlin.test.assertEquals
import kotlin.test.assertFailsWith
import kotlin.test.assertTrue

class GreyPngDecoderTest {
    @TempDir
    lateinit var folder: File

    private val decoder = GreyPngDecoder(16, 8)
    private val pixels = Random(3).nextBytes(16 * 8)
    private val file by lazy { folder.resolve("image.png").also { SyntheticRecording.writePng(it, pixels, 16) } }

    @Test
    fun pixelsAreThoseOfTheFile() {
        val target = ByteBuffer.allocateDirect(16 * 8)
        decoder.decode(file, target)
        assertContentEquals(pixels, ByteArray(16 * 8).also { target.flip().get(it) })
    }

    @Test
    fun otherPixelFormatsAreRefused() {
        val types = listOf(
            BufferedImage.TYPE_USHORT_GRAY,
            BufferedImage.TYPE_3BYTE_BGR,
            BufferedImage.TYPE_4BYTE_ABGR,
            BufferedImage.TYPE_BYTE_INDEXED,
            BufferedImage.TYPE_BYTE_BINARY,
        )
        for (type in types) {
            SyntheticRecording.writePng(file, ByteArray(16 * 8), 16, type)
            assertEquals("16x8, another pixel format", failure().found)
        }
    }

    @Test
    fun otherSizesAreRefused() {
        SyntheticRecording.writePng(file, pixels, 8)
        val failure = failure()
        assertEquals("16x8, 8-bit grey", failure.expected)
        assertEquals("8x16, 8-bit grey", failure.found)
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

    private fun failure(): RecordingException {
        val failure = assertFailsWith<RecordingException> { decoder.decode(file, ByteBuffer.allocate(16 * 8)) }
        assertEquals(file, failure.file)
        return failure
    }
}
