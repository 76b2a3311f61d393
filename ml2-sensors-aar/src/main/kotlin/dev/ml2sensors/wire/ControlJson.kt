package dev.ml2sensors.wire

import kotlinx.serialization.KSerializer
import kotlinx.serialization.json.Json
import kotlinx.serialization.serializer
import java.nio.ByteBuffer
import java.nio.charset.CharacterCodingException

/** Encodes and decodes JSON bodies as PROTOCOL.md requires: one object in UTF-8; unknown keys are ignored. */
internal object ControlJson {
    private val json = Json { ignoreUnknownKeys = true }

    inline fun <reified T> encode(body: T): ByteArray = encode(serializer<T>(), body)

    /** @throws ProtocolException when [bytes] are not a body of type [T]. */
    inline fun <reified T> decode(bytes: ByteArray): T = decode(serializer<T>(), bytes)

    fun <T> encode(serializer: KSerializer<T>, body: T): ByteArray = json.encodeToString(serializer, body).toByteArray()

    fun <T> decode(serializer: KSerializer<T>, bytes: ByteArray): T {
        val name = serializer.descriptor.serialName.substringAfterLast('.')
        try {
            val tree = StrictJson.parse(Charsets.UTF_8.newDecoder().decode(ByteBuffer.wrap(bytes)).toString())
            StrictJson.checkType(serializer.descriptor, tree)
            return json.decodeFromJsonElement(serializer, tree)
        } catch (e: CharacterCodingException) {
            throw ProtocolException(ErrorCode.MALFORMED, "expected a $name in UTF-8: ${e.message}")
        } catch (e: IllegalArgumentException) { // SerializationException is one
            val reason = printable(e.message.orEmpty().lineSequence().first())
            throw ProtocolException(ErrorCode.MALFORMED, "expected a $name: $reason")
        }
    }
}
