package dev.ml2sensors.app

import android.os.Looper
import org.robolectric.Shadows.shadowOf
import java.time.Duration
import kotlin.test.assertTrue

/** Runs the main thread's tasks, on a fast clock, until [isSo]. */
internal fun eventually(what: String, isSo: () -> Boolean) {
    val end = System.nanoTime() + 20_000_000_000
    while (!isSo()) {
        assertTrue(System.nanoTime() < end, "not within 20 s: $what")
        shadowOf(Looper.getMainLooper()).idleFor(Duration.ofMillis(20))
        Thread.sleep(1)
    }
}
