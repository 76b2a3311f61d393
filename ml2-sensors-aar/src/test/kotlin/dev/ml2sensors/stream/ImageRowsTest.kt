package dev.ml2sensors.stream

import dev.ml2sensors.message.Header
import dev.ml2sensors.message.Image
import dev.ml2sensors.message.Time
import dev.ml2sensors.source.CaptureMetadata
import dev.ml2sensors.source.ImageSample
import org.junit.jupiter.api.Test
import java.nio.ByteBuffer
import kotlin.test.assertContentEquals
import kotlin.test.assertEquals
import kotlin.test.assertFailsWith

/** sensor_msgs/Image: `step` is the length of a row, and `data` has step * height bytes. */
class ImageRowsTest {
    @Test
    fun wholeRowsAreSentAsTheyAre() = assertEquals((0..17).toList(), bytes(image(18)))

    @Test
    fun whatFollowsTheLastRowIsNotSent() = assertEquals((0..17).toList(), bytes(image(23)))

    @Test
    fun aLastRowWithoutItsPaddingIsPadded() = assertEquals((0..15) + listOf(0, 0), bytes(image(16)))

    @Test
    fun anImageThatLacksARowIsNone() {
        assertFailsWith<IllegalArgumentException> { image(12) }
    }

    @Test
    fun theBuffersOfTheSampleStayAsTheyAre() {
        val pixels = ByteBuffer.allocate(23)
        image(pixels)
        assertContentEquals(intArrayOf(0, 23), intArrayOf(pixels.position(), pixels.limit()))
    }

    @Test
    fun aPlaneBesideACompressedImageHasRowsWithoutPadding() {
        val confidence = image(ByteBuffer.wrap(ByteArray(48) { it.toByte() }), strideBytes = 0)
        assertEquals(16u to 48, confidence.step to confidence.data.remaining())
    }

    private fun image(size: Int) = image(ByteBuffer.wrap(ByteArray(size) { it.toByte() }))

    /** Returns an image of rows of 4 pixels, and 2 bytes of padding. */
    private fun image(pixels: ByteBuffer, strideBytes: Int = 6): Image {
        val planes = listOf(ImageSample.Plane(ImageSample.IMAGE, pixels))
        val sample = ImageSample(0, 0, width = 4, height = 3, strideBytes, null, null, CaptureMetadata(), planes) {}
        return sample.toImage(Header(Time(0, 0u), "frame"), "mono8", sample.pixels)
    }

    private fun bytes(image: Image): List<Int> {
        assertEquals(6u, image.step)
        return List(image.data.remaining()) { image.data.get(image.data.position() + it).toInt() }
    }
}
