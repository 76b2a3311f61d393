package dev.ml2sensors

import kotlinx.serialization.encodeToString
import kotlinx.serialization.json.Json
import java.nio.file.Path
import kotlin.io.path.createDirectories
import kotlin.io.path.writeText

/** Writes [results] to build/reports/[name] as JSON. */
internal inline fun <reified T> report(name: String, results: List<T>) {
    val file = Path.of(System.getProperty("basedir"), "..", "build", "reports", name)
    file.parent.createDirectories()
    file.writeText(Json { prettyPrint = true }.encodeToString(results))
}
