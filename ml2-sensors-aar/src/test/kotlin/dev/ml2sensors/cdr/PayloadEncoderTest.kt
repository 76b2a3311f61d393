package dev.ml2sensors.cdr

import dev.ml2sensors.message.CompressedImage
import dev.ml2sensors.message.Header
import dev.ml2sensors.message.Image
import dev.ml2sensors.message.StringMessage
import dev.ml2sensors.message.Time
import kotlinx.serialization.Serializable
import org.junit.jupiter.api.Test
import java.nio.ByteBuffer
import kotlin.test.assertContentEquals
import kotlin.test.assertEquals
import kotlin.test.assertFailsWith
import kotlin.test.assertNull
import kotlin.test.assertTrue

class PayloadEncoderTest {
    private val encoder = PayloadEncoder()

    private fun image(data: ByteBuffer) = CompressedImage(Header(Time(1, 2u), frameId = "eye"), format = "jpeg", data)

    @Test
    fun thePrefixEndsWithTheLengthOfTheBorrowedBytes() {
        val payload = encoder.encode(CompressedImage.serializer(), image(ByteBuffer.allocateDirect(258)))
        assertContentEquals(
            hex(
                """
                00 01 00 00              # encapsulation
                01 00 00 00 02 00 00 00  # stamp
                04 00 00 00 65 79 65 00  # frame_id
                05 00 00 00              # 5 bytes of format
                6a 70 65 67 00           # format
                00 00 00                 # padding to 4
                02 01 00 00              # 258 bytes of data
                """,
            ),
            payload.prefix.bytes(),
        )
        assertEquals(36 + 258, payload.size)
    }

    @Test
    fun theBytesAreBorrowedAndTheMessageIsLeftAsItWas() {
        val pixels = ByteBuffer.allocateDirect(8).position(2).limit(6)
        val data = encoder.encode(CompressedImage.serializer(), image(pixels)).data!!
        pixels.put(3, 42)
        assertContentEquals(byteArrayOf(0, 42, 0, 0), data.bytes())
        data.position(data.limit())
        assertEquals(2, pixels.position())
    }

    @Test
    fun aMessageWithoutAByteSequenceIsAllPrefix() {
        val payload = encoder.encode(StringMessage.serializer(), StringMessage("abc"))
        assertContentEquals(hex("00010000 04000000 61626300"), payload.prefix.bytes())
        assertNull(payload.data)
    }

    @Test
    fun theSizeStaysWhenTheBuffersAreRead() {
        val payload = encoder.encode(CompressedImage.serializer(), image(ByteBuffer.allocateDirect(3)))
        payload.prefix.position(payload.prefix.limit())
        assertEquals(36 + 3, payload.size)
    }

    @Test
    fun anEncodingKnowsNothingOfTheOneBefore() {
        val long = StringMessage("x".repeat(5000))
        val short = image(ByteBuffer.allocate(4))
        val alone = PayloadEncoder().encode(CompressedImage.serializer(), short).prefix.bytes()
        encoder.encode(StringMessage.serializer(), long)
        assertContentEquals(alone, encoder.encode(CompressedImage.serializer(), short).prefix.bytes())
        assertNull(encoder.encode(StringMessage.serializer(), long).data)
        assertContentEquals(alone, encoder.encode(CompressedImage.serializer(), short).prefix.bytes())
    }

    @Test
    fun aRefusedMessageDoesNotSpoilTheNext() {
        assertFailsWith<IllegalArgumentException> {
            encoder.encode(StringMessage.serializer(), StringMessage("\uDC00"))
        }
        val payload = encoder.encode(StringMessage.serializer(), StringMessage("abc"))
        assertContentEquals(hex("00010000 04000000 61626300"), payload.prefix.bytes())
    }

    @Serializable
    class BytesFirst(
        @Serializable(ByteSequenceSerializer::class)
        val data: ByteBuffer,
        val after: Byte,
    )

    @Test
    fun bytesBeforeOtherFieldsAreCopied() {
        val payload = encoder.encode(BytesFirst.serializer(), BytesFirst(ByteBuffer.wrap(byteArrayOf(7, 8)), after = 9))
        assertContentEquals(hex("00010000 02000000 0708 09"), payload.prefix.bytes())
        assertNull(payload.data)
    }

    @Serializable
    internal class Nested(val image: CompressedImage, val after: Byte)

    @Test
    fun nothingMayFollowAMessageThatEndsWithBorrowedBytes() {
        val error = assertFailsWith<IllegalArgumentException> {
            encoder.encode(Nested.serializer(), Nested(image(ByteBuffer.allocate(1)), after = 0))
        }
        assertEquals("Expected the byte sequence last, but found after", error.message)
    }

    @Test
    fun theHeapUsedDoesNotGrowWithTheImage() {
        assertTrue(allocatedPerEncoding(megapixels = 1) < 1_000)
        assertTrue(allocatedPerEncoding(megapixels = 12) < 1_000)
    }

    private fun allocatedPerEncoding(megapixels: Int): Long {
        val size = megapixels * 1_000_000
        val pixels = ByteBuffer.allocateDirect(size)
        val header = Header(Time(1, 2u), frameId = "world_left_optical_frame")
        val image = Image(header, 1000u, size.toUInt() / 1000u, "mono8", 0u, size.toUInt() / 1000u, pixels)
        val threads =
            java.lang.management.ManagementFactory
                .getThreadMXBean() as com.sun.management.ThreadMXBean
        val encodings = 1_000
        repeat(encodings) { encoder.encode(Image.serializer(), image) }
        val before = threads.currentThreadAllocatedBytes
        repeat(encodings) { encoder.encode(Image.serializer(), image) }
        return (threads.currentThreadAllocatedBytes - before) / encodings
    }

    private fun ByteBuffer.bytes() = ByteArray(remaining()).also(duplicate()::get)
}
