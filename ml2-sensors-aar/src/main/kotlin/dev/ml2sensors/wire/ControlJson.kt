package dev.ml2sensors.wire

import kotlinx.serialization.KSerializer
import kotlinx.serialization.SerializationException
import kotlinx.serialization.json.Json
import kotlinx.serialization.serializer
import java.nio.ByteBuffer
import java.nio.charset.CharacterCodingException

/** JSON bodies as PROTOCOL.md wants them: UTF-8, unknown keys ignored, nesting bounded. */
internal object ControlJson {
    private const val MAX_DEPTH = 16

    private val json = Json {
        ignoreUnknownKeys = true
        encodeDefaults = true
        explicitNulls = false
    }

    inline fun <reified T> encode(body: T): ByteArray = encode(serializer<T>(), body)

    /** @throws ProtocolException when [bytes] are not a body of type [T]. */
    inline fun <reified T> decode(bytes: ByteArray): T = decode(serializer<T>(), bytes)

    fun <T> encode(serializer: KSerializer<T>, body: T): ByteArray = json.encodeToString(serializer, body).toByteArray()

    fun <T> decode(serializer: KSerializer<T>, bytes: ByteArray): T {
        val name = serializer.descriptor.serialName.substringAfterLast('.')
        try {
            val text = Charsets.UTF_8.newDecoder().decode(ByteBuffer.wrap(bytes)).toString()
            checkDepth(text, name)
            return json.decodeFromString(serializer, text)
        } catch (e: CharacterCodingException) {
            throw ProtocolException(ErrorCode.MALFORMED, "expected a $name in UTF-8: ${e.message}")
        } catch (e: SerializationException) {
            throw ProtocolException(ErrorCode.MALFORMED, "expected a $name: ${e.message?.lineSequence()?.first()}")
        }
    }

    private fun checkDepth(text: String, name: String) {
        var depth = 0
        var inString = false
        var escaped = false
        for (c in text) {
            when {
                escaped -> escaped = false
                inString && c == '\\' -> escaped = true
                c == '"' -> inString = !inString
                inString -> Unit
                c == '{' || c == '[' -> depth++
                c == '}' || c == ']' -> depth--
            }
            if (depth > MAX_DEPTH) {
                throw ProtocolException(ErrorCode.MALFORMED, "expected a $name nested at most $MAX_DEPTH deep")
            }
        }
    }
}
