package dev.ml2sensors.source

import org.junit.jupiter.api.Test
import kotlin.concurrent.thread
import kotlin.test.assertContentEquals
import kotlin.test.assertEquals
import kotlin.test.assertFailsWith
import kotlin.test.assertNull

class ImageSampleTest {
    private val pool = CountedBuffers(bufferBytes = 8)

    @Test
    fun memoryGoesBackWithTheLastRelease() {
        val sample = sample("image", "flags")
        sample.retain()
        sample.release()
        assertEquals(2, pool.outstanding)
        sample.release()
        assertEquals(0, pool.outstanding)
    }

    @Test
    fun pixelsThrowAfterTheRelease() {
        val sample = sample("image")
        sample.release()
        assertFailsWith<IllegalStateException> { sample.pixels }
        assertFailsWith<IllegalStateException> { sample.plane("image") }
        assertFailsWith<IllegalStateException> { sample.copy() }
        assertFailsWith<IllegalStateException> { sample.retain() }
    }

    @Test
    fun oneReleaseTooManyIsMisuseAndFreesNothing() {
        val sample = sample("image")
        sample.release()
        val other = sample("image", "flags")
        assertFailsWith<IllegalStateException> { sample.release() }
        assertFailsWith<IllegalStateException> { sample.release() }
        assertEquals(2, pool.outstanding)
        other.release()
    }

    @Test
    fun planesAreFoundByTheirRole() {
        val sample = sample("image", "flags")
        assertEquals(0, sample.pixels.get(0))
        assertEquals(1, sample.plane("flags")?.get(0))
        assertNull(sample.plane("confidence"))
    }

    @Test
    fun everyViewOfThePixelsHasAPositionOfItsOwn() {
        val sample = sample("image")
        sample.pixels.get()
        assertEquals(8, sample.pixels.remaining())
        assertContentEquals(byteArrayOf(0, 0, 0, 0, 0, 0, -128, 63), sample.copy())
        assertEquals(8, sample.pixels.remaining())
    }

    @Test
    fun numbersInThePixelsAreLittleEndian() {
        assertEquals(1f, sample("image").pixels.getFloat(4))
    }

    @Test
    fun aSampleWithoutAnImageSaysSo() {
        assertFailsWith<IllegalStateException> { sample("flags").pixels }
    }

    @Test
    fun usesByManyThreadsEndInOneReturn() {
        repeat(200) {
            val sample = sample("image")
            val users = List(4) {
                sample.retain()
                thread { sample.release() }
            }
            sample.release()
            users.forEach(Thread::join)
            assertEquals(0, pool.outstanding)
        }
    }

    /** Its first byte in each plane is the plane's index; 1f at offset 4. */
    private fun sample(vararg roles: String): ImageSample {
        val planes = roles.mapIndexed { index, role ->
            val pixels = pool.acquire().put(index.toByte()).put(ByteArray(5)).put(-128).put(63).flip()
            ImageSample.Plane(role, pixels)
        }
        return ImageSample(1, 2, 2, 4, 2, pose = null, intrinsics = null, CaptureMetadata(), planes) {
            planes.forEach { pool.release(it.pixels) }
        }
    }
}
