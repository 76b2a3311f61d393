package dev.ml2sensors.cdr

import dev.ml2sensors.message.StringMessage
import dev.ml2sensors.message.Time
import kotlinx.serialization.ExperimentalSerializationApi
import kotlinx.serialization.Serializable
import kotlinx.serialization.SerializationException
import kotlinx.serialization.builtins.ListSerializer
import kotlinx.serialization.builtins.serializer
import org.junit.jupiter.api.Test
import java.nio.ByteBuffer
import kotlin.test.assertContentEquals
import kotlin.test.assertEquals
import kotlin.test.assertFailsWith
import kotlin.test.assertTrue

@OptIn(ExperimentalSerializationApi::class)
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

    @Test
    fun textThatCdrCannotCarryIsRefused() {
        for (text in listOf("\uD83D", "a\u0000b")) {
            val message = StringMessage(text)
            assertFailsWith<IllegalArgumentException> { Cdr.encodeToByteArray(StringMessage.serializer(), message) }
        }
    }

    @Serializable
    data class Optional(val value: Int?)

    @Serializable
    data class Keyed(val values: Map<String, Int>)

    @Serializable
    class Empty

    @Test
    fun whatRosHasNoTypeForIsRefused() {
        assertFailsWith<SerializationException> { Cdr.encodeToByteArray(Optional.serializer(), Optional(null)) }
        assertFailsWith<SerializationException> { Cdr.encodeToByteArray(Optional.serializer(), Optional(1)) }
        val present = hex("0001000001000000")
        assertFailsWith<SerializationException> { Cdr.decodeFromByteArray(Optional.serializer(), present) }
        assertFailsWith<SerializationException> { Cdr.encodeToByteArray(Keyed.serializer(), Keyed(mapOf())) }
        assertFailsWith<SerializationException> { Cdr.encodeToByteArray(Empty.serializer(), Empty()) }
    }

    @Test
    fun aMessageLargerThanTheFirstBufferIsWhole() {
        val text = "x".repeat(100_000)
        val bytes = Cdr.encodeToByteArray(ListSerializer(String.serializer()), listOf(text, text))
        assertTrue(bytes.size > 200_000)
        assertEquals(listOf(text, text), Cdr.decodeFromByteArray(ListSerializer(String.serializer()), bytes))
    }
}
