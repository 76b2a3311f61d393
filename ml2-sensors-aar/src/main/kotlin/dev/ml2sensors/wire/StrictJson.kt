package dev.ml2sensors.wire

import kotlinx.serialization.SerializationException
import kotlinx.serialization.descriptors.PrimitiveKind
import kotlinx.serialization.descriptors.SerialDescriptor
import kotlinx.serialization.descriptors.SerialKind
import kotlinx.serialization.descriptors.StructureKind
import kotlinx.serialization.json.Json
import kotlinx.serialization.json.JsonArray
import kotlinx.serialization.json.JsonElement
import kotlinx.serialization.json.JsonNull
import kotlinx.serialization.json.JsonObject
import kotlinx.serialization.json.JsonPrimitive

/**
 * Checks JSON for PROTOCOL.md's rules that kotlinx.serialization does not check. Everything here throws
 * SerializationException.
 */
internal object StrictJson {
    private const val MAX_DEPTH = 16
    private val LITERAL = Regex("""-?(0|[1-9]\d*)(\.\d+)?([eE][+-]?\d+)?|true|false""")

    /** Parses one value of RFC 8259, nested at most [MAX_DEPTH] deep, whose strings are Unicode scalar values. */
    fun parse(text: String): JsonElement {
        checkBrackets(text)
        return Json.parseToJsonElement(text).also(::checkLiterals)
    }

    /** Checks that no value of [element] has another JSON type than [descriptor]: "7" is no number, 1e2 no integer. */
    fun checkType(descriptor: SerialDescriptor, element: JsonElement) {
        if (element is JsonNull && descriptor.isNullable) return
        when (descriptor.kind) {
            StructureKind.CLASS -> for ((key, value) in element.of<JsonObject>(descriptor)) {
                val index = descriptor.getElementIndex(key)
                if (index >= 0) checkType(descriptor.getElementDescriptor(index), value)
            }

            StructureKind.MAP ->
                element.of<JsonObject>(descriptor).values.forEach { checkType(descriptor.getElementDescriptor(1), it) }

            StructureKind.LIST ->
                element.of<JsonArray>(descriptor).forEach { checkType(descriptor.getElementDescriptor(0), it) }

            else -> {
                val literal = element.of<JsonPrimitive>(descriptor)
                if (!literal.isOfKind(descriptor.kind)) fail("expected a ${descriptor.kind}, found $literal")
            }
        }
    }

    private inline fun <reified T : JsonElement> JsonElement.of(descriptor: SerialDescriptor): T =
        this as? T ?: fail("expected a ${descriptor.kind}, found $this")

    private fun JsonPrimitive.isOfKind(kind: SerialKind): Boolean = when (kind) {
        PrimitiveKind.STRING -> isString
        PrimitiveKind.INT, PrimitiveKind.LONG -> !isString && content.toLongOrNull() != null
        else -> !isString
    }

    private fun checkLiterals(element: JsonElement) {
        when (element) {
            is JsonObject -> element.forEach { (key, value) ->
                checkText(key)
                checkLiterals(value)
            }

            is JsonArray -> element.forEach(::checkLiterals)

            is JsonNull -> Unit

            is JsonPrimitive ->
                if (element.isString) {
                    checkText(element.content)
                } else if (!LITERAL.matches(element.content)) {
                    fail("expected a number, true, false or null, found ${element.content}")
                }
        }
    }

    private fun checkText(text: String) {
        if (!Charsets.UTF_8.newEncoder().canEncode(text)) fail("expected text of Unicode scalar values")
    }

    private fun checkBrackets(text: String) {
        var depth = 0
        var inString = false
        var escaped = false
        for (c in text) {
            when {
                inString && c < ' ' -> fail("expected control characters to be escaped, found ${c.code}")
                escaped -> escaped = false
                inString && c == '\\' -> escaped = true
                c == '"' -> inString = !inString
                inString -> Unit
                c == '{' || c == '[' -> depth++
                c == '}' || c == ']' -> depth--
            }
            if (depth > MAX_DEPTH) fail("expected values nested at most $MAX_DEPTH deep")
        }
    }

    private fun fail(message: String): Nothing = throw SerializationException(message)
}
