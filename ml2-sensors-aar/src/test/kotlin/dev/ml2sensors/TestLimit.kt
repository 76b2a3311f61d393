package dev.ml2sensors

import kotlin.time.Duration
import kotlin.time.Duration.Companion.seconds

/** How long a test waits for what has to come. It only ends a hang; a slower machine may set more. */
internal val TEST_LIMIT: Duration = (System.getenv("ML2S_TEST_LIMIT_S") ?: "120").toInt().seconds
