package dev.ml2sensors

import app.cash.turbine.ReceiveTurbine
import app.cash.turbine.test
import kotlinx.coroutines.flow.Flow
import kotlinx.serialization.encodeToString
import kotlinx.serialization.json.Json
import java.nio.file.Path
import kotlin.io.path.createDirectories
import kotlin.io.path.writeText
import kotlin.time.Duration
import kotlin.time.Duration.Companion.seconds

/** The longest time that a test waits. It only ends a hang; a slower machine may set more. */
internal val TEST_LIMIT: Duration = (System.getenv("ML2S_TEST_LIMIT_S") ?: "120").toInt().seconds

/** As Turbine's function of this name, which by itself waits for 3 s. */
internal suspend fun <T> Flow<T>.test(validate: suspend ReceiveTurbine<T>.() -> Unit): Unit =
    test(timeout = TEST_LIMIT, validate = validate)

/** Writes [results] to build/reports/[name] as JSON. */
internal inline fun <reified T> report(name: String, results: List<T>) {
    val file = Path.of(System.getProperty("basedir"), "..", "build", "reports", name)
    file.parent.createDirectories()
    file.writeText(Json { prettyPrint = true }.encodeToString(results))
}
