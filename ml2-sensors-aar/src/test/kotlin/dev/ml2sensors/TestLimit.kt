package dev.ml2sensors

import app.cash.turbine.ReceiveTurbine
import app.cash.turbine.test
import kotlinx.coroutines.flow.Flow
import kotlin.time.Duration
import kotlin.time.Duration.Companion.seconds

/** How long a test waits for what has to come. It only ends a hang; a slower machine may set more. */
internal val TEST_LIMIT: Duration = (System.getenv("ML2S_TEST_LIMIT_S") ?: "120").toInt().seconds

/** As Turbine's function of this name, which by itself waits for 3 s. */
internal suspend fun <T> Flow<T>.test(validate: suspend ReceiveTurbine<T>.() -> Unit): Unit =
    test(timeout = TEST_LIMIT, validate = validate)
