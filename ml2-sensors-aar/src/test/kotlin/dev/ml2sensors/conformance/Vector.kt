package dev.ml2sensors.conformance

import kotlinx.serialization.json.Json
import kotlinx.serialization.json.JsonObject
import kotlinx.serialization.json.int
import kotlinx.serialization.json.jsonArray
import kotlinx.serialization.json.jsonObject
import kotlinx.serialization.json.jsonPrimitive
import java.nio.file.Path
import java.util.zip.CRC32
import kotlin.io.path.listDirectoryEntries
import kotlin.io.path.readText
import kotlin.test.assertEquals

/** A case of tests/conformance/vectors with the bytes that it describes; its README says what the JSON means. */
internal class Vector(val name: String, val case: JsonObject, val bytes: ByteArray) {
    override fun toString() = name

    companion object {
        private val ROOT = Path.of("../tests/conformance/vectors")
        private val sentFrames by lazy { SentFrames(read(ROOT.resolve("valid/bodies.json")), kinds()) }

        /** The well-formed body of this key. */
        fun validBody(key: String): JsonObject = read(ROOT.resolve("valid/bodies.json")).getValue(key).jsonObject

        fun load(folder: String, name: String): Vector = loadAll(folder).single { it.name == name }

        /** All cases of a folder, in the order of their names. */
        fun loadAll(folder: String): List<Vector> {
            val cases = ROOT.resolve(folder).listDirectoryEntries("*.json").flatMap { read(it).entries }
            check(cases.isNotEmpty()) { "no cases in $folder" }
            val sorted = cases.sortedBy { it.key }
            return sorted.map { (name, case) -> Vector(name, case.jsonObject, bytes(case.jsonObject)) }
        }

        /** The number of each kind by its name: the wire cases have them all. */
        private fun kinds(): Map<String, Int> {
            val frames = loadAll("wire").flatMap { it.case.getValue("frames").jsonArray }.map { it.jsonObject }
            return frames.associate {
                it.getValue("name").jsonPrimitive.content to it.getValue("kind").jsonPrimitive.int
            }
        }

        private fun read(file: Path) = Json.parseToJsonElement(file.readText()).jsonObject

        private fun bytes(case: JsonObject): ByteArray {
            val bytes = case["sent"]?.let { sentFrames.bytes(it.jsonArray) } ?: pieces(case.getValue("bytes"))
            val crc32 = CRC32().apply { update(bytes) }.value
            case["crc32"]?.let { assertEquals(it.jsonPrimitive.content, "%08x".format(crc32), case.toString()) }
            return bytes
        }
    }
}
