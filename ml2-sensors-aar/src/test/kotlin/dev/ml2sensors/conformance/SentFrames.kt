package dev.ml2sensors.conformance

import kotlinx.serialization.json.JsonArray
import kotlinx.serialization.json.JsonElement
import kotlinx.serialization.json.JsonObject
import kotlinx.serialization.json.JsonPrimitive
import kotlinx.serialization.json.int
import kotlinx.serialization.json.jsonArray
import kotlinx.serialization.json.jsonObject
import kotlinx.serialization.json.jsonPrimitive
import kotlinx.serialization.json.long
import java.nio.ByteBuffer
import java.nio.ByteOrder

/** Bytes of what a malformed case sends: frames of these [kinds] as changes of the [valid] ones. README.md has the keys. */
internal class SentFrames(private val valid: JsonObject, private val kinds: Map<String, Int>) {
    fun bytes(parts: JsonArray): ByteArray =
        parts.map { if (it is JsonObject && "frame" in it) frame(it) else piece(it) }.joined()

    private fun frame(part: JsonObject): ByteArray {
        val body = body(part)
        val header = part["header"]?.jsonObject.orEmpty()
        fun field(name: String, default: Int = 0) = header[name]?.jsonPrimitive?.long ?: default.toLong()
        val kind = part.getValue("frame").jsonPrimitive
        val frame = ByteBuffer.allocate(HEADER_BYTES + body.size).order(ByteOrder.LITTLE_ENDIAN)
        frame.put((header["magic"]?.jsonPrimitive?.content ?: "M2").toByteArray())
        frame.put(field("version", 1).toByte())
        frame.put((if (kind.isString) kinds.getValue(kind.content) else kind.int).toByte())
        frame.putShort(field("flags").toShort()).putShort(field("channel").toShort())
        frame.putInt(field("sequence").toInt()).putInt(field("length", body.size).toInt())
        frame.putLong(field("capture")).putLong(field("send")).put(body)
        return frame.array().copyOf(frame.capacity() - (part["cut_bytes"]?.jsonPrimitive?.int ?: 0))
    }

    private fun body(part: JsonObject): ByteArray {
        part["body"]?.let { return pieces(it) }
        part["json"]?.let { return text(it).toByteArray() }
        val base = valid[(part["valid"] ?: part.getValue("frame")).jsonPrimitive.content] ?: return ByteArray(0)
        return if (base is JsonArray) pieces(base) else changed(base.jsonObject, part)
    }

    private fun changed(base: JsonObject, part: JsonObject): ByteArray {
        val removed = part["without"]?.jsonArray.orEmpty().associate { it.jsonPrimitive.content to null }
        val changes = removed + part["with"]?.jsonObject.orEmpty()
        val body = changes.entries.fold(base) { it, (path, value) -> it.changed(path.split("."), value) }
        var bytes = text(body).toByteArray()
        part["replace"]?.let { bytes = bytes.replaced(it.jsonPrimitive.content.toByteArray(), pieces(part["by"])) }
        return pieces(part["before"]) + bytes + pieces(part["after"])
    }

    private fun JsonObject.changed(path: List<String>, value: JsonElement?): JsonObject {
        val key = path.first()
        val inner = if (path.size == 1) value else getValue(key).jsonObject.changed(path.drop(1), value)
        return JsonObject(if (inner == null) this - key else this + (key to inner))
    }

    /** Compact JSON, in which the number REQUEST has no quotes. */
    private fun text(body: JsonElement) = body.toString().replace("\"$REQUEST\"", REQUEST)

    private fun ByteArray.replaced(old: ByteArray, new: ByteArray): ByteArray {
        val at = (0..size - old.size).single { copyOfRange(it, it + old.size).contentEquals(old) }
        return copyOf(at) + new + copyOfRange(at + old.size, size)
    }

    private companion object {
        const val HEADER_BYTES = 32
        val REQUEST = "REQUEST".padEnd(32, '_')
    }
}

/** The bytes of a list of pieces, as case files have them; no list is no bytes. */
internal fun pieces(pieces: JsonElement?): ByteArray = pieces?.jsonArray.orEmpty().map(::piece).joined()

private fun piece(piece: JsonElement): ByteArray {
    if (piece is JsonPrimitive) return piece.content.toByteArray()
    fun text(key: String) = piece.jsonObject[key]?.jsonPrimitive?.content
    if (text("pattern") != null) return ByteArray(text("length")!!.toInt()) { (it % 251).toByte() }
    val bytes = text("text")?.toByteArray() ?: text("hex")!!.replace(" ", "").hexToByteArray()
    return List(text("times")?.toInt() ?: 1) { bytes }.joined()
}

private fun List<ByteArray>.joined(): ByteArray =
    ByteBuffer.allocate(sumOf { it.size }).also { whole -> forEach(whole::put) }.array()
