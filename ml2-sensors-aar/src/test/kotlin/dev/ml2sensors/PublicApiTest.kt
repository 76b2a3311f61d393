package dev.ml2sensors

import org.jetbrains.kotlin.abi.tools.AbiFilters
import org.jetbrains.kotlin.abi.tools.AbiTools
import org.junit.jupiter.api.Test
import java.io.File
import kotlin.test.assertNull

/** Compares the public names with api/ml2-sensors.api, in the format of Kotlin's binary-compatibility-validator. */
class PublicApiTest {
    @Test
    fun whatIsPublicChangesOnPurposeOnly() {
        val tools = AbiTools.getInstance()
        val committed = File("api/ml2-sensors.api")
        val found = File("target/ml2-sensors.api")
        val classes = File("target/classes").walk().filter { it.extension == "class" }.toList()
        found.bufferedWriter().use { tools.printJvmDump(it, classes, AbiFilters.EMPTY) }
        if (System.getenv("REWRITE_API") != null) found.copyTo(committed, overwrite = true)
        assertNull(tools.filesDiff(committed, found), "`make api` rewrites $committed")
    }
}
