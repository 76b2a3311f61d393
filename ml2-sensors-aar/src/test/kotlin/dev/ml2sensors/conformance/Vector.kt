package dev.ml2sensors.conformance

import kotlinx.serialization.json.Json
import kotlinx.serialization.json.JsonObject
import kotlinx.serialization.json.jsonObject
import java.nio.file.Path
import kotlin.io.path.listDirectoryEntries
import kotlin.io.path.nameWithoutExtension
import kotlin.io.path.readBytes
import kotlin.io.path.readText

/** One case of tests/conformance/vectors; its README says what the JSON means. */
internal class Vector(val name: String, val case: JsonObject, val bytes: ByteArray) {
    companion object {
        private val ROOT = Path.of("../tests/conformance/vectors")

        fun load(folder: String, name: String): Vector {
            val case = ROOT.resolve("$folder/$name.json")
            val bytes = ROOT.resolve("$folder/$name.bin").readBytes()
            return Vector(name, Json.parseToJsonElement(case.readText()).jsonObject, bytes)
        }

        fun loadAll(folder: String): List<Vector> {
            val cases = ROOT.resolve(folder).listDirectoryEntries("*.json").sorted()
            check(cases.isNotEmpty()) { "no vectors in $folder" }
            return cases.map { load(folder, it.nameWithoutExtension) }
        }
    }
}
