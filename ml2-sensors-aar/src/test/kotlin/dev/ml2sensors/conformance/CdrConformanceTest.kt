package dev.ml2sensors.conformance

import dev.ml2sensors.cdr.Cdr
import dev.ml2sensors.cdr.CdrDecodingException
import dev.ml2sensors.cdr.PayloadEncoder
import dev.ml2sensors.message.rosType
import kotlinx.serialization.ExperimentalSerializationApi
import org.junit.jupiter.api.Test
import org.junit.jupiter.params.ParameterizedTest
import org.junit.jupiter.params.provider.MethodSource
import java.nio.ByteBuffer
import kotlin.test.assertContentEquals
import kotlin.test.assertEquals
import kotlin.test.assertFailsWith

@OptIn(ExperimentalSerializationApi::class)
internal class CdrConformanceTest {
    @Test
    fun everyMessageTypeHasAVector() {
        assertEquals(MESSAGE_SERIALIZERS.keys, vectors().map { it.serializer.rosType }.toSet())
    }

    @ParameterizedTest
    @MethodSource("vectors")
    fun encodesToTheBytesOfTheVector(vector: CdrVector) {
        assertContentEquals(vector.bytes, Cdr.encodeToByteArray(vector.serializer, vector.message))
        assertEquals(vector.size, vector.bytes.size)
    }

    @ParameterizedTest
    @MethodSource("vectors")
    fun decodesToTheFieldsOfTheVector(vector: CdrVector) {
        val decoded = Cdr.decodeFromByteArray(vector.serializer, vector.bytes)
        assertEquals(
            fieldsJson.encodeToString(vector.serializer, vector.message),
            fieldsJson.encodeToString(vector.serializer, decoded),
        )
    }

    @ParameterizedTest
    @MethodSource("vectors")
    fun prefixAndBorrowedPixelsAreTheBytesOfTheVector(vector: CdrVector) {
        val payload = PayloadEncoder().encode(vector.serializer, vector.message)
        assertEquals(vector.size, payload.size)
        assertEquals(vector.prefixSize ?: vector.size, payload.prefix.remaining())
        assertEquals(vector.prefixSize?.let { vector.size - it }, payload.data?.remaining())
        val whole = ByteBuffer.allocate(payload.size).put(payload.prefix)
        payload.data?.let(whole::put)
        assertContentEquals(vector.bytes, whole.array())
    }

    @ParameterizedTest
    @MethodSource("vectors")
    fun aVectorCutAnywhereOrWithAByteTooManyIsAnError(vector: CdrVector) {
        for (size in 0..<vector.size) {
            assertFailsWith<CdrDecodingException>("cut to $size bytes") {
                Cdr.decodeFromByteArray(vector.serializer, vector.bytes.copyOf(size))
            }
        }
        assertFailsWith<CdrDecodingException> {
            Cdr.decodeFromByteArray(vector.serializer, vector.bytes + 0)
        }
    }

    companion object {
        @JvmStatic
        fun vectors() = CdrVector.all
    }
}
