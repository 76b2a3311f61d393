package dev.ml2sensors.cdr

import dev.ml2sensors.message.CameraInfo
import dev.ml2sensors.message.Header
import dev.ml2sensors.message.Image
import dev.ml2sensors.message.StringMessage
import dev.ml2sensors.message.TFMessage
import dev.ml2sensors.message.Time
import kotlinx.serialization.ExperimentalSerializationApi
import kotlinx.serialization.KSerializer
import kotlinx.serialization.Serializable
import kotlinx.serialization.SerializationException
import kotlinx.serialization.builtins.ByteArraySerializer
import kotlinx.serialization.builtins.FloatArraySerializer
import kotlinx.serialization.builtins.ListSerializer
import kotlinx.serialization.builtins.serializer
import org.junit.jupiter.api.Test
import java.lang.management.ManagementFactory
import java.nio.ByteBuffer
import kotlin.test.assertContentEquals
import kotlin.test.assertEquals
import kotlin.test.assertFailsWith
import kotlin.test.assertTrue

@OptIn(ExperimentalSerializationApi::class, ExperimentalUnsignedTypes::class)
class CdrTest {
    @Serializable
    data class Integers(
        val i8: Byte,
        val u8: UByte,
        val i16: Short,
        val u16: UShort,
        val i32: Int,
        val u32: UInt,
        val i64: Long,
        val u64: ULong,
    )

    @Test
    fun integersAreLittleEndianAndAlignedToTheirSize() {
        val message = Integers(-2, 254u, -3, 65_533u, -4, 4_294_967_292u, -5, 18_446_744_073_709_551_611u)
        val decoded =
            assertCdr(
                Integers.serializer(),
                message,
                """
                00 01 00 00              # encapsulation
                fe                       # i8
                fe                       # u8
                fd ff                    # i16
                fd ff                    # u16
                00 00                    # padding to 4
                fc ff ff ff              # i32
                fc ff ff ff              # u32
                fb ff ff ff ff ff ff ff  # i64, at 16
                fb ff ff ff ff ff ff ff  # u64
                """,
            )
        assertEquals(message, decoded)
    }

    @Serializable
    data class Mixed(val yes: Boolean, val number: Double, val no: Boolean, val fraction: Float, val tail: Boolean)

    @Test
    fun alignmentCountsFromTheEndOfTheEncapsulationHeader() {
        val message = Mixed(yes = true, number = 1.5, no = false, fraction = -2f, tail = true)
        val decoded =
            assertCdr(
                Mixed.serializer(),
                message,
                """
                00 01 00 00              # encapsulation
                01                       # yes
                00 00 00 00 00 00 00     # padding to 8
                00 00 00 00 00 00 f8 3f  # number
                00                       # no
                00 00 00                 # padding to 4
                00 00 00 c0              # fraction
                01                       # tail; nothing pads the end
                """,
            )
        assertEquals(message, decoded)
    }

    @Test
    fun paddingReadMayHoldAnything() {
        val decoded =
            Cdr.decodeFromByteArray(
                Mixed.serializer(),
                hex("00010000 01 a1a2a3a4a5a6a7 000000000000f83f 00 b1b2b3 000000c0 01"),
            )
        assertEquals(Mixed(yes = true, number = 1.5, no = false, fraction = -2f, tail = true), decoded)
    }

    @Test
    fun stringsAreSizedInUtf8BytesAndEndInNul() {
        val decoded =
            assertCdr(
                StringMessage.serializer(),
                StringMessage("aß€😀"),
                """
                00 01 00 00  # encapsulation
                0b 00 00 00  # 11 bytes
                61           # a
                c3 9f        # ß
                e2 82 ac     # €
                f0 9f 98 80  # 😀, two units of UTF-16
                00           # NUL
                """,
            )
        assertEquals(StringMessage("aß€😀"), decoded)
    }

    @Test
    fun anEmptyStringIsOneNul() {
        assertCdr(StringMessage.serializer(), StringMessage(""), "00010000 01000000 00")
    }

    @Serializable
    class Arrays(
        val sequence: ShortArray,
        @FixedLength(3) val fixed: ShortArray,
        val empty: DoubleArray,
        val last: Byte,
    )

    @Test
    fun onlySequencesHaveALength() {
        val message = Arrays(shortArrayOf(1, 2, 3), shortArrayOf(4, 5, 6), doubleArrayOf(), last = 7)
        val decoded =
            assertCdr(
                Arrays.serializer(),
                message,
                """
                00 01 00 00        # encapsulation
                03 00 00 00        # 3 elements
                01 00 02 00 03 00  # sequence
                04 00 05 00 06 00  # fixed
                00 00 00 00        # 0 elements, and no padding to 8 as none needs it
                07                 # last
                """,
            )
        assertContentEquals(message.fixed, decoded.fixed)
        assertContentEquals(message.sequence, decoded.sequence)
    }

    @Test
    fun aFixedLengthArrayOfAnotherLengthIsRefused() {
        val message = Arrays(shortArrayOf(), shortArrayOf(4, 5), doubleArrayOf(), last = 7)
        val error =
            assertFailsWith<IllegalArgumentException> { Cdr.encodeToByteArray(Arrays.serializer(), message) }
        assertEquals("Expected 3 elements, but found 2", error.message)
    }

    @Serializable
    data class Lists(val times: List<Time>, val names: List<String>, @FixedLength(2) val pair: List<List<UByte>>)

    @Test
    fun sequencesHoldMessagesTextAndSequences() {
        val message = Lists(listOf(Time(1, 2u), Time(-3, 4u)), listOf("", "b"), listOf(listOf(1u), listOf()))
        val decoded =
            assertCdr(
                Lists.serializer(),
                message,
                """
                00 01 00 00              # encapsulation
                02 00 00 00              # 2 times
                01 00 00 00 02 00 00 00  # times[0]
                fd ff ff ff 04 00 00 00  # times[1]
                02 00 00 00              # 2 names
                01 00 00 00 00           # names[0], empty
                00 00 00                 # padding to 4
                02 00 00 00 62 00        # names[1], "b"
                00 00                    # padding to 4
                01 00 00 00 01           # pair[0]; a fixed length does not pass on to the elements
                00 00 00                 # padding to 4
                00 00 00 00              # pair[1]
                """,
            )
        assertEquals(message, decoded)
    }

    @Serializable
    class Bytes(
        val before: Byte,
        @Serializable(ByteSequenceSerializer::class)
        val data: ByteBuffer,
        @FixedLength(2)
        @Serializable(ByteSequenceSerializer::class)
        val pair: ByteBuffer,
    )

    @Test
    fun aByteSequenceIsWhatLiesBetweenPositionAndLimit() {
        val data =
            ByteBuffer
                .allocateDirect(5)
                .put(hex("0a 0b 0c 0d 0e"))
                .position(1)
                .limit(4)
        val decoded =
            assertCdr(
                Bytes.serializer(),
                Bytes(before = 1, data, pair = ByteBuffer.wrap(hex("1a 1b"))),
                """
                00 01 00 00  # encapsulation
                01           # before
                00 00 00     # padding to 4
                03 00 00 00  # 3 bytes
                0b 0c 0d     # data
                1a 1b        # pair, of fixed length
                """,
            )
        assertEquals(1, data.position())
        assertEquals(ByteBuffer.wrap(hex("0b 0c 0d")), decoded.data)
        assertEquals(ByteBuffer.wrap(hex("1a 1b")), decoded.pair)
    }

    @Serializable
    data class Wide(
        val before: Byte,
        @Serializable(WideStringSerializer::class)
        val text: String,
        val list: List<
            @Serializable(WideStringSerializer::class)
            String,
            >,
        val after: Byte,
    )

    /** As rclpy's `serialize_message` writes test_msgs/msg/WStrings. */
    @Test
    fun aWideStringHasFourBytesForEachUnitAndNoNul() {
        val message = Wide(before = 1, "aß€😀", listOf("", "b"), after = 2)
        val decoded =
            assertCdr(
                Wide.serializer(),
                message,
                """
                00 01 00 00              # encapsulation
                01 00 00 00              # before, padding to 4
                05 00 00 00              # 5 units
                61 00 00 00 df 00 00 00  # a, ß
                ac 20 00 00              # €
                3d d8 00 00 00 de 00 00  # 😀
                02 00 00 00              # 2 strings
                00 00 00 00              # list[0], empty
                01 00 00 00 62 00 00 00  # list[1], "b"
                02                       # after
                """,
            )
        assertEquals(message, decoded)
    }

    @Serializable
    class Nothing

    @Serializable
    data object Single

    @Serializable
    class Nothings(val first: Nothing, val list: List<Nothing>, val single: Single, val last: Short)

    @Test
    fun aMessageWithoutFieldsIsOneByte() {
        assertCdr(Nothing.serializer(), Nothing(), "00010000 00")
        assertCdr(Single.serializer(), Single, "00010000 00")
        assertCdr(
            Nothings.serializer(),
            Nothings(Nothing(), List(3) { Nothing() }, Single, last = 7),
            """
            00 01 00 00  # encapsulation
            00 00 00 00  # first, padding to 4
            03 00 00 00  # 3 messages
            00 00 00     # list
            00           # single
            07 00        # last
            """,
        )
        assertEquals(Single, Cdr.decodeFromByteArray(Single.serializer(), hex("00010000 55")))
    }

    @Serializable
    class Numbers(
        val bytes: ByteArray,
        @FixedLength(2) val ubytes: UByteArray,
        val shorts: ShortArray,
        @FixedLength(2) val ushorts: UShortArray,
        val ints: IntArray,
        @FixedLength(1) val uints: UIntArray,
        val longs: LongArray,
        @FixedLength(1) val ulongs: ULongArray,
        val floats: FloatArray,
        @FixedLength(1) val doubles: DoubleArray,
        val booleans: BooleanArray,
    )

    @Test
    fun arraysOfEachNumberAreAlignedAsTheirElements() {
        val message =
            Numbers(
                byteArrayOf(-1), ubyteArrayOf(254u, 2u), shortArrayOf(-3), ushortArrayOf(65_532u, 4u), intArrayOf(-5),
                uintArrayOf(4_294_967_290u), longArrayOf(-7), ulongArrayOf(18_446_744_073_709_551_608u),
                floatArrayOf(1.5f), doubleArrayOf(-2.5), booleanArrayOf(true, false),
            )
        val listing =
            """
            00 01 00 00                       # encapsulation
            01 00 00 00 ff fe 02 00           # bytes, ubytes, padding to 4
            01 00 00 00 fd ff fc ff 04 00     # shorts, ushorts
            00 00                             # padding to 4
            01 00 00 00 fb ff ff ff           # ints
            fa ff ff ff                       # uints
            01 00 00 00                       # 1 long
            00 00 00 00                       # padding to 8
            f9 ff ff ff ff ff ff ff           # longs
            f8 ff ff ff ff ff ff ff           # ulongs
            01 00 00 00 00 00 c0 3f           # floats
            00 00 00 00 00 00 04 c0           # doubles
            02 00 00 00 01 00                 # booleans
            """
        val decoded = assertCdr(Numbers.serializer(), message, listing)
        assertContentEquals(message.ubytes, decoded.ubytes)
        assertContentEquals(message.ulongs, decoded.ulongs)
        assertContentEquals(message.doubles, decoded.doubles)
        assertContentEquals(message.booleans, decoded.booleans)
    }

    @Test
    fun aMessageIsReadBetweenPositionAndLimitOfAnyBuffer() {
        val message = hex("aaaa 00010000 03000000 6162 00 bbbb")
        val buffers =
            listOf(ByteBuffer.wrap(message), ByteBuffer.wrap(message).asReadOnlyBuffer(), ByteBuffer.allocateDirect(15))
        buffers.last().put(message)
        for (buffer in buffers) {
            buffer.position(2).limit(13)
            assertEquals(StringMessage("ab"), Cdr.decode(StringMessage.serializer(), buffer))
            assertEquals(2, buffer.position())
            assertEquals(13, buffer.limit())
        }
    }

    /** The second is what Cyclone DDS writes: three bytes of padding, which the options count. */
    @Test
    fun bytesAfterTheMessageAreIgnoredWhereTheCallerAllowsThem() {
        for (listing in listOf("00010000 02000000 6100 55aa", "00010003 02000000 6100 000000")) {
            val bytes = ByteBuffer.wrap(hex(listing))
            assertEquals(StringMessage("a"), Cdr.decode(StringMessage.serializer(), bytes, allowsTail = true))
            assertFailsWith<CdrDecodingException> { Cdr.decode(StringMessage.serializer(), bytes) }
        }
    }

    private fun layout(serializer: KSerializer<*>) = serializer.descriptor.layout()

    @Test
    fun theLayoutSaysHowCdrWalksThroughAType() {
        assertEquals("[44ssddddddd]", layout(TFMessage.serializer()))
        assertEquals("44s44s14[1]", layout(Image.serializer()))
        assertEquals("44s44s[d](d*9)(d*9)(d*12)444444b", layout(CameraInfo.serializer()))
        assertEquals("1w[w]1", layout(Wide.serializer()))
        assertEquals("1[1]12", layout(Nothings.serializer()))
        assertEquals("[1](1*2)[2](2*2)[4](4*1)[8](8*1)[f](d*1)[b]", layout(Numbers.serializer()))
        assertEquals("[44][s]([1]*2)", layout(Lists.serializer()))
    }

    @Test
    fun textThatCdrCannotCarryIsRefused() {
        for (text in listOf("\uD83D", "a\u0000b")) {
            val message = StringMessage(text)
            assertFailsWith<IllegalArgumentException> { Cdr.encodeToByteArray(StringMessage.serializer(), message) }
        }
        for (text in listOf("\uD83D", "a\uDE00b", "\uD83D\uD83D\uDE00")) {
            assertFailsWith<IllegalArgumentException> { Cdr.encodeToByteArray(WideStringSerializer, text) }
        }
    }

    @Serializable
    data class Optional(val value: Int?)

    @Serializable
    data class Keyed(val values: Map<String, Int>)

    @Serializable
    class Node(val children: List<Node>)

    @Test
    fun whatRosHasNoTypeForIsRefused() {
        assertFailsWith<SerializationException> { Cdr.encodeToByteArray(Optional.serializer(), Optional(null)) }
        assertFailsWith<SerializationException> { Cdr.encodeToByteArray(Optional.serializer(), Optional(1)) }
        val present = hex("0001000001000000")
        assertFailsWith<SerializationException> { Cdr.decodeFromByteArray(Optional.serializer(), present) }
        assertFailsWith<SerializationException> { Cdr.encodeToByteArray(Keyed.serializer(), Keyed(mapOf())) }
        for (serializer in listOf(Optional.serializer(), Keyed.serializer(), Node.serializer(), Char.serializer())) {
            assertFailsWith<SerializationException> { serializer.descriptor.layout() }
        }
    }

    @Test
    fun aMessageLargerThanTheFirstBufferIsWhole() {
        val text = "x".repeat(100_000)
        val bytes = Cdr.encodeToByteArray(ListSerializer(String.serializer()), listOf(text, text))
        assertTrue(bytes.size > 200_000)
        assertEquals(listOf(text, text), Cdr.decodeFromByteArray(ListSerializer(String.serializer()), bytes))
    }

    @Serializable
    class PointField(val name: String, val offset: UInt, val datatype: UByte, val count: UInt)

    @Serializable
    class PointCloud2<Bytes>(
        val header: Header,
        val height: UInt,
        val width: UInt,
        val fields: List<PointField>,
        val isBigendian: Boolean,
        val pointStep: UInt,
        val rowStep: UInt,
        val data: Bytes,
        val isDense: Boolean,
    )

    @Test
    fun aCloudOfAMegabyteIsReadInPlaceOrCopiedOnce() {
        val fields = List(4) { PointField("xyzi".substring(it, it + 1), it.toUInt() * 4u, 7u, 1u) }
        val header = Header(Time(1, 2u), "lidar")
        val cloud = PointCloud2(header, 1u, 65_536u, fields, false, 16u, MEGABYTE.toUInt(), ByteArray(MEGABYTE), true)
        val bytes = Cdr.encodeToByteArray(PointCloud2.serializer(ByteArraySerializer()), cloud)
        assertEquals("44s44[s414]b44[1]b", layout(PointCloud2.serializer(ByteSequenceSerializer)))
        val message = ByteBuffer.allocateDirect(bytes.size).put(bytes).flip()
        for ((serializer, copied) in listOf(ByteSequenceSerializer to 0, ByteArraySerializer() to MEGABYTE)) {
            val allocated = bytesOfDecoding(PointCloud2.serializer(serializer), message)
            assertTrue(allocated in copied..<copied + 4_000, "$allocated bytes")
        }
    }

    @Test
    fun aMegabyteOfNumbersIsCopiedOnce() {
        val bytes = Cdr.encodeToByteArray(FloatArraySerializer(), FloatArray(MEGABYTE / Float.SIZE_BYTES))
        val allocated = bytesOfDecoding(FloatArraySerializer(), ByteBuffer.wrap(bytes))
        assertTrue(allocated in MEGABYTE..<MEGABYTE + 4_000, "$allocated bytes")
    }

    /** The median of what one decoding allocates. */
    private fun bytesOfDecoding(serializer: KSerializer<*>, message: ByteBuffer): Long {
        val threads = ManagementFactory.getThreadMXBean() as com.sun.management.ThreadMXBean
        val decodings =
            List(51) {
                val before = threads.currentThreadAllocatedBytes
                Cdr.decode(serializer, message)
                threads.currentThreadAllocatedBytes - before
            }
        return decodings.sorted()[25]
    }

    private companion object {
        const val MEGABYTE = 1 shl 20
    }
}
