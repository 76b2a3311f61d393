package dev.ml2sensors.cdr

import dev.ml2sensors.conformance.CdrVector
import dev.ml2sensors.conformance.MESSAGE_SERIALIZERS
import dev.ml2sensors.conformance.fieldsJson
import kotlinx.serialization.ExperimentalSerializationApi
import kotlinx.serialization.KSerializer
import org.junit.jupiter.api.Test
import java.nio.ByteBuffer
import kotlin.random.Random
import kotlin.test.assertContentEquals
import kotlin.test.assertEquals
import kotlin.test.assertTrue

@OptIn(ExperimentalSerializationApi::class)
class CdrPropertyTest {
    private val random = Random(20_260_119)

    @Test
    fun whateverIsEncodedIsDecodedToTheSame() {
        for (serializer in MESSAGE_SERIALIZERS.values) {
            repeat(50) { assertRoundTrip(serializer) }
        }
    }

    private fun <T> assertRoundTrip(serializer: KSerializer<T>) {
        val message = serializer.deserialize(RandomMessage(random))
        val bytes = Cdr.encodeToByteArray(serializer, message)
        val decoded = Cdr.decodeFromByteArray(serializer, bytes)
        assertEquals(fieldsJson.encodeToString(serializer, message), fieldsJson.encodeToString(serializer, decoded))
        assertContentEquals(bytes, Cdr.encodeToByteArray(serializer, decoded))
        val withTail = ByteBuffer.allocateDirect(bytes.size + 7).put(bytes).put(random.nextBytes(7)).flip()
        val fromDirect = Cdr.decode(serializer, withTail, allowsTail = true)
        assertContentEquals(bytes, Cdr.encodeToByteArray(serializer, fromDirect))
    }

    @Test
    fun randomBytesAreAMessageOrADecodingError() {
        for (serializer in MESSAGE_SERIALIZERS.values) {
            repeat(200) {
                val bytes = random.nextBytes(random.nextInt(4, 200))
                hex("00010000").copyInto(bytes)
                isDecoded(serializer, bytes)
            }
        }
    }

    @Test
    fun damagedMessagesAreAMessageOrADecodingError() {
        val outcomes =
            CdrVector.all.flatMap { vector ->
                List(200) { isDecoded(vector.serializer, damaged(vector.bytes)) }
            }
        assertTrue(true in outcomes)
        assertTrue(false in outcomes)
    }

    private fun damaged(bytes: ByteArray): ByteArray {
        val result = bytes.copyOf()
        repeat(random.nextInt(1, 4)) { result[random.nextInt(result.size)] = random.nextInt().toByte() }
        return result
    }

    /** Anything thrown but a [CdrDecodingException] fails the test. */
    private fun isDecoded(serializer: KSerializer<*>, bytes: ByteArray): Boolean = try {
        Cdr.decodeFromByteArray(serializer, bytes)
        true
    } catch (_: CdrDecodingException) {
        false
    }
}
