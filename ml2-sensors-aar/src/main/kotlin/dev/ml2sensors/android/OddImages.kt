package dev.ml2sensors.android

import java.util.concurrent.atomic.AtomicInteger

/** Counts images in a row that cannot be used. A few are losses; after [MOST], [fail] ends the run. Thread-safe. */
internal class OddImages(private val fail: (Exception) -> Unit) {
    private val inARow = AtomicInteger()

    fun addUsable(): Unit = inARow.set(0)

    fun addOdd(cause: Exception) {
        if (inARow.incrementAndGet() >= MOST) fail(cause)
    }

    companion object {
        /** As ML2S_MOST_UNUSABLE_CAPTURES of the native library: a second of images. */
        const val MOST = 30
    }
}
