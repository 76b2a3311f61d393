package dev.ml2sensors

import org.junit.jupiter.api.Test
import java.nio.file.Path
import kotlin.io.path.extension
import kotlin.io.path.readLines
import kotlin.io.path.walk
import kotlin.test.assertEquals
import kotlin.test.assertTrue

/** Tests which packages import each other, and Android. */
class PackagesTest {
    private val imports = Path.of("src/main/kotlin").walk().filter { it.extension == "kt" }.flatMap { file ->
        val lines = file.readLines()
        val own = lines.first { it.startsWith("package ") }.removePrefix("package ")
        lines.filter { it.startsWith("import ") }.map { own to it.removePrefix("import ") }
    }.toList()

    @Test
    fun dependenciesPointOneWay() {
        val known = ORDER.flatten().toSet()
        assertEquals(
            emptySet(),
            imports.map {
                packageOf(it.first)
            }.toSet() - known,
            "packages without a place in the order",
        )
        val wrong = imports.filter { (own, imported) ->
            imported.startsWith("$ROOT.") && packageOf(imported) != packageOf(own) && rank(imported) >= rank(own)
        }
        assertEquals(emptyList(), wrong)
    }

    @Test
    fun onlyTheAdaptersKnowAndroid() {
        val wrong = imports.filter { (own, imported) ->
            (imported.startsWith("android") || imported.startsWith("com.unity3d.")) && packageOf(own) !in ADAPTERS
        }
        assertEquals(emptyList(), wrong)
    }

    @Test
    fun onlyTheAdaptersKnowTheNativeLibrary() {
        val wrong = imports.filter { (own, imported) ->
            packageOf(imported) == "capture" && packageOf(own) !in ADAPTERS + "capture" && imported !in COMPRESSION
        }
        assertEquals(emptyList(), wrong)
    }

    @Test
    fun theSourcesAreFound() {
        assertTrue(imports.any { (own, imported) -> own == "$ROOT.session" && imported == "$ROOT.wire.FrameKind" })
    }

    private fun rank(name: String) = ORDER.indexOfFirst { packageOf(name) in it }

    /** The word after the root; empty for what stands in the root itself. */
    private fun packageOf(name: String): String =
        name.removePrefix(ROOT).removePrefix(".").substringBefore('.').takeIf { it == it.lowercase() }.orEmpty()

    private companion object {
        const val ROOT = "dev.ml2sensors"
        val ADAPTERS = setOf("android", "unity")

        /** Pipelines compress images of any source, and need the library only when a format wants it. */
        val COMPRESSION =
            setOf("ImageCodec", "ImageEncoder", "VideoChannel", "VideoStream").map { "$ROOT.capture.$it" }.toSet()

        /** Each may import those before it. */
        val ORDER = listOf(
            setOf("", "cdr", "table"),
            setOf("message"),
            setOf("source"),
            setOf("capture"),
            setOf("clock"),
            setOf("pacing"),
            setOf("wire"),
            setOf("transport"),
            setOf("session"),
            setOf("pairing"),
            setOf("ros"),
            setOf("stream"),
            setOf("android"),
            setOf("unity"),
        )
    }
}
