package dev.ml2sensors.app

import android.os.Looper
import org.robolectric.Shadows.shadowOf
import java.time.Duration
import kotlin.test.assertTrue
import kotlin.time.Duration.Companion.seconds
import kotlin.time.TimeSource

private val LIMIT = (System.getenv("ML2S_TEST_LIMIT_S") ?: "120").toInt().seconds

/** Runs the main thread's tasks, on a fast clock, until [isSo]. */
internal fun eventually(what: String, isSo: () -> Boolean) {
    val begin = TimeSource.Monotonic.markNow()
    while (!isSo()) {
        assertTrue(begin.elapsedNow() < LIMIT, "not within $LIMIT: $what")
        shadowOf(Looper.getMainLooper()).idleFor(Duration.ofMillis(20))
        Thread.sleep(1)
    }
}
