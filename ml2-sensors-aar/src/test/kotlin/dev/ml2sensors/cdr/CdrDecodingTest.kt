package dev.ml2sensors.cdr

import dev.ml2sensors.message.CompressedImage
import dev.ml2sensors.message.PoseArray
import dev.ml2sensors.message.RegionOfInterest
import dev.ml2sensors.message.StringMessage
import dev.ml2sensors.message.Time
import kotlinx.serialization.ExperimentalSerializationApi
import kotlinx.serialization.KSerializer
import kotlinx.serialization.Serializable
import kotlinx.serialization.builtins.DoubleArraySerializer
import kotlinx.serialization.builtins.ListSerializer
import org.junit.jupiter.api.Test
import kotlin.test.assertEquals
import kotlin.test.assertFailsWith

@OptIn(ExperimentalSerializationApi::class)
class CdrDecodingTest {
    private fun <T> assertRefused(message: String, serializer: KSerializer<T>, listing: String) {
        val error = assertFailsWith<CdrDecodingException> { Cdr.decodeFromByteArray(serializer, hex(listing)) }
        assertEquals(message, error.message)
    }

    @Test
    fun anotherEncapsulationIsRefused() {
        assertRefused(
            "Expected encapsulation 0x00010000, but found 0x00000000 at offset 0",
            Time.serializer(),
            "00 00 00 00  # CDR_BE",
        )
        assertRefused(
            "Expected encapsulation 0x00010000, but found 0x00030000 at offset 0",
            Time.serializer(),
            "00 03 00 00  # PL_CDR_LE",
        )
        assertRefused("Expected 4 bytes, but found 3 at offset 0", Time.serializer(), "00 01 00")
    }

    @Test
    fun aBoolIsZeroOrOne() {
        assertRefused(
            "Expected bool of 0 or 1, but found 255 at offset 20",
            RegionOfInterest.serializer(),
            """
            00 01 00 00              # encapsulation
            00 00 00 00 00 00 00 00  # x_offset, y_offset
            00 00 00 00 00 00 00 00  # height, width
            ff                       # do_rectify
            """,
        )
    }

    @Test
    fun aStringEndsInNulAndHoldsNoOther() {
        val string = StringMessage.serializer()
        assertRefused("Expected NUL, but found 0x63 at offset 10", string, "00010000 03000000 616263")
        assertRefused(
            "Expected text without NUL, but found one at index 1 at offset 8",
            string,
            "00010000 03000000 610000",
        )
        assertRefused("Expected string size of at least 1, but found 0 at offset 4", string, "00010000 00000000")
    }

    @Test
    fun aStringIsUtf8() {
        val notUtf8 =
            listOf(
                "00010000 02000000 80 00       # continuation alone",
                "00010000 03000000 c0af 00     # overlong",
                "00010000 04000000 eda080 00   # surrogate",
                "00010000 05000000 f4908080 00 # beyond Unicode",
                "00010000 02000000 c3 00       # cut",
            )
        for (listing in notUtf8) {
            assertRefused("Expected UTF-8, but found invalid bytes at offset 8", StringMessage.serializer(), listing)
        }
    }

    /** Each length is refused because what remains is too short for it, before an array of that length is made. */
    @Test
    fun aLengthBeyondTheBytesThatRemainIsRefused() {
        assertRefused(
            "Expected length of at most 2, but found 4294967295 at offset 4",
            StringMessage.serializer(),
            "00010000 ffffffff 6100",
        )
        assertRefused(
            "Expected length of at most 2, but found 3 at offset 4",
            StringMessage.serializer(),
            "00010000 03000000 6100",
        )
        assertRefused(
            "Expected length of at most 1, but found 2 at offset 4",
            DoubleArraySerializer(),
            "00010000 02000000 000000000000f03f 00000000",
        )
        assertRefused(
            "Expected length of at most 1, but found 2 at offset 20",
            PoseArray.serializer(),
            """
            00 01 00 00              # encapsulation
            00 00 00 00 00 00 00 00  # stamp
            01 00 00 00 00 00 00 00  # frame_id, padding
            02 00 00 00              # 2 poses of 56 bytes
            ${"00".repeat(56)}
            """,
        )
        assertRefused(
            "Expected length of at most 3, but found 2147483648 at offset 28",
            CompressedImage.serializer(),
            """
            00 01 00 00              # encapsulation
            00 00 00 00 00 00 00 00  # stamp
            01 00 00 00 00 00 00 00  # frame_id, padding
            01 00 00 00 00 00 00 00  # format, padding
            00 00 00 80              # bytes of data
            01 02 03
            """,
        )
    }

    @Test
    fun aWideStringIsUtf16() {
        for ((listing, found) in listOf(
            "00010000 01000000 0000 0100" to "0x00010000 at offset 8",
            "00010000 01000000 61000080" to "0x80000061 at offset 8",
            "00010000 02000000 61000000 3dd80000" to "an unpaired surrogate at offset 12",
            "00010000 02000000 00de0000 61000000" to "an unpaired surrogate at offset 8",
        )) {
            assertRefused("Expected UTF-16, but found $found", WideStringSerializer, listing)
        }
        assertRefused(
            "Expected length of at most 1, but found 2 at offset 4",
            WideStringSerializer,
            "00010000 02000000 61000000 6200",
        )
    }

    @Serializable
    class Large(@FixedLength(1 shl 28) val numbers: DoubleArray)

    @Serializable
    class Pair(@FixedLength(2) val bytes: ByteArray)

    @Test
    fun anArrayIsNotMadeForBytesThatAreNotThere() {
        assertRefused(
            "Expected 268435456 elements, but found bytes for at most 2 at offset 4",
            Large.serializer(),
            "00010000 ${"00".repeat(20)}",
        )
        assertRefused(
            "Expected length of at most 2, but found 3 at offset 4",
            ListSerializer(Pair.serializer()),
            "00010000 03000000 0102 0304 05",
        )
    }

    @Test
    fun bytesAfterTheMessageAreRefused() {
        assertRefused(
            "Expected end of message, but found 1 more bytes at offset 12",
            Time.serializer(),
            "00010000 01000000 02000000 00",
        )
    }
}
