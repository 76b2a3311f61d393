package dev.ml2sensors.capture

import dev.ml2sensors.source.ImageSample
import dev.ml2sensors.source.testImage
import dev.ml2sensors.table.StreamTable
import kotlinx.coroutines.runBlocking
import org.junit.jupiter.api.AfterEach
import org.junit.jupiter.api.BeforeEach
import org.junit.jupiter.api.Test
import java.io.ByteArrayInputStream
import java.nio.ByteBuffer
import java.nio.ByteOrder
import javax.imageio.ImageIO
import kotlin.math.abs
import kotlin.test.assertEquals
import kotlin.test.assertFailsWith
import kotlin.test.assertNotNull
import kotlin.test.assertNull
import kotlin.test.assertSame
import kotlin.test.assertTrue

class ImageEncoderTest {
    @BeforeEach
    fun begin(): Unit = Simulation.begin()

    @AfterEach
    fun nothingIsLeft() {
        assertEquals(0, Native.mappedBytes())
        Simulation.assertIsLeftAsFound()
    }

    @Test
    fun aGreyImageIsAJpegThatJavaReads() {
        val sample = grey(61, 43, strideBytes = 64)
        val jpeg = ImageEncoder(StreamTable.worldLeft, ImageCodec.GREY_JPEG).use { encoder ->
            encoder.encode(sample, 95)!!.use { it.copy() }
        }
        val image = ImageIO.read(ByteArrayInputStream(jpeg))
        assertEquals(61 to 43, image.width to image.height)
        assertEquals(1, image.raster.numBands)
        for (y in 0 until 43) {
            for (x in 0 until 61) assertTrue(abs(image.raster.getSample(x, y, 0) - (2 * x + y)) <= 3, "$x, $y")
        }
    }

    @Test
    fun depthIsThePayloadOfCompressedDepth() {
        // 2 zeros, 1 value, 1000 * 2 as 3 bits each, lowest first: 0x218af300
        val pixels = direct(12).putFloat(0f).putFloat(Float.NaN).putFloat(1f).flip()
        val sample = testImage(3, 1, listOf(pixels.asImage()), strideBytes = 12)
        val payload = ImageEncoder(StreamTable.depth, ImageCodec.DEPTH_RVL).use { encoder ->
            encoder.encode(sample, 0)!!.use { it.copy() }
        }
        val expected = direct(24).putInt(0).putFloat(0f).putFloat(0f).putInt(3).putInt(1).putInt(0x218af300).flip()
        assertEquals(expected, ByteBuffer.wrap(payload))
    }

    @Test
    fun allButTheImageIsThatOfTheSample() {
        val sample = grey(16, 8, strideBytes = 16)
        ImageEncoder(StreamTable.worldLeft, ImageCodec.GREY_JPEG).use { encoder ->
            val encoded = encoder.encode(sample, 80)!!
            assertEquals(sample.captureNanos, encoded.captureNanos)
            assertEquals(sample.frameNumber, encoded.frameNumber)
            assertEquals(sample.width to sample.height, encoded.width to encoded.height)
            assertEquals(0, encoded.strideBytes)
            assertSame(sample.metadata, encoded.metadata)
            encoded.release()
            assertEquals(128, sample.pixels.remaining(), "the sample is still the caller's")
        }
    }

    @Test
    fun otherPlanesStayUntilTheEncodedSampleIsReleased() {
        var isGivenBack = false
        val confidence = direct(64)
        val planes = listOf(direct(64).asImage(), ImageSample.Plane("confidence", confidence))
        val sample = testImage(4, 4, planes, strideBytes = 16) { isGivenBack = true }
        ImageEncoder(StreamTable.depth, ImageCodec.DEPTH_RVL).use { encoder ->
            val encoded = encoder.encode(sample, 0)!!
            sample.release()
            assertEquals(confidence, encoded.plane("confidence"))
            assertNull(encoded.plane("flags"))
            assertEquals(false, isGivenBack)
            encoded.release()
            assertEquals(true, isGivenBack)
        }
    }

    @Test
    fun imagesWithoutOtherPlanesDoNotKeepTheSample() {
        var isGivenBack = false
        val sample = grey(16, 8, strideBytes = 16) { isGivenBack = true }
        ImageEncoder(StreamTable.worldLeft, ImageCodec.GREY_JPEG).use { encoder ->
            val encoded = encoder.encode(sample, 80)!!
            sample.release()
            assertTrue(isGivenBack)
            encoded.release()
        }
    }

    @Test
    fun thereIsNoImageWhileAllSlotsAreLeased() {
        val sample = grey(16, 8, strideBytes = 16)
        ImageEncoder(StreamTable.worldLeft, ImageCodec.GREY_JPEG).use { encoder ->
            val held = List(SlotPool.SLOTS) { assertNotNull(encoder.encode(sample, 80)) }
            assertNull(encoder.encode(sample, 80))
            held.first().release()
            encoder.encode(sample, 80)!!.release()
            held.drop(1).forEach(ImageSample::release)
        }
    }

    @Test
    fun anImageOutlivesItsEncoder() {
        val sample = grey(16, 8, strideBytes = 16)
        val encoded = ImageEncoder(StreamTable.worldLeft, ImageCodec.GREY_JPEG).use { it.encode(sample, 80)!! }
        assertEquals(0xd8ff.toShort(), encoded.pixels.short)
        encoded.release()
    }

    @Test
    fun whatCannotBeEncodedIsRefusedAndKeepsNoSlot() {
        val sample = grey(16, 8, strideBytes = 16)
        val heap = testImage(16, 8, listOf(ByteBuffer.allocate(128).asImage()))
        val short = testImage(16, 9, listOf(direct(128).asImage()))
        ImageEncoder(StreamTable.worldLeft, ImageCodec.GREY_JPEG).use { encoder ->
            repeat(SlotPool.SLOTS + 1) {
                assertRefused("the image is not in a direct buffer") { encoder.encode(heap, 80) }
                assertRefused("grey_jpeg: quality 101, but it is 1 to 100") { encoder.encode(sample, 101) }
                assertRefused("grey_jpeg: the image has 128 bytes, but 16 x 9 pixels need 144") {
                    encoder.encode(short, 80)
                }
            }
        }
        assertRefused("grey_jpeg: 65536 x 1 pixels, but each side has 1 to 65535") {
            Native.mostEncodedBytes(ImageCodec.GREY_JPEG.code, 65536, 1)
        }
        assertRefused("65535 x 65535 pixels need more than 2 GiB") {
            Native.mostEncodedBytes(ImageCodec.DEPTH_RVL.code, 65535, 65535)
        }
    }

    @Test
    fun theLatestFrameIsStillTheRawOne() = runBlocking<Unit> {
        val stream = StreamTable.worldLeft
        CaptureFixture().use { fixture ->
            LocalFrames.view(stream, true)
            ImageEncoder(stream, ImageCodec.GREY_JPEG).use { encoder ->
                fixture.image(stream) { image ->
                    val latest = FrameBlock(1)
                    val sizeBytes = encoder.encode(image, 80)!!.use { it.pixels.remaining() }
                    assertTrue(sizeBytes in 1 until image.pixels.remaining())
                    assertTrue(Simulation.acquireLatest(stream.number, 0, latest.memory))
                    assertEquals(latest[0].width, latest[0].strideBytes(NativeFrame.IMAGE))
                    latest[0].release()
                }
            }
            LocalFrames.view(stream, false)
        }
    }

    private inline fun <T> ImageSample.use(action: (ImageSample) -> T): T = try {
        action(this)
    } finally {
        release()
    }

    private fun assertRefused(message: String, action: () -> Unit) =
        assertEquals(message, assertFailsWith<IllegalArgumentException> { action() }.message)

    private companion object {
        fun direct(sizeBytes: Int): ByteBuffer = ByteBuffer.allocateDirect(sizeBytes).order(ByteOrder.LITTLE_ENDIAN)

        fun ByteBuffer.asImage() = ImageSample.Plane(ImageSample.IMAGE, this)

        /** The pixel at x, y is 2 x + y; the rows begin at an odd place of a larger buffer. */
        fun grey(width: Int, height: Int, strideBytes: Int, giveBack: () -> Unit = {}): ImageSample {
            val pixels = direct(3 + height * strideBytes + 5).position(3).limit(3 + height * strideBytes)
            for (y in 0 until height) {
                for (x in 0 until width) pixels.put(3 + y * strideBytes + x, (2 * x + y).toByte())
            }
            return testImage(width, height, listOf(pixels.asImage()), strideBytes = strideBytes, giveBack = giveBack)
        }
    }
}
