package dev.ml2sensors.android

import android.util.Log
import dev.ml2sensors.source.ColorPoses
import dev.ml2sensors.source.DeviceClock
import dev.ml2sensors.source.SourceException

/**
 * The pose tracker of the colour camera while the camera runs. When the vendor's library fails, as when its perception
 * restarts, the tracker is opened again after a pause that grows up to [LONGEST_PAUSE_NANOS]. Used by one thread.
 */
internal class CameraTracker(private val poses: ColorPoses, private val clock: DeviceClock) : AutoCloseable {
    private var tracker: ColorPoses.Tracker? = null
    private var openFromNanos = Long.MIN_VALUE
    private var pauseNanos = SHORTEST_PAUSE_NANOS

    /** Opens the tracker, so that the first image does not wait for it. */
    fun open() {
        ask { null }
    }

    /** Returns what [question] returns; null if the vendor's library is missing, fails, or has just failed. */
    fun <T : Any> ask(question: (ColorPoses.Tracker) -> T?): T? = try {
        opened()?.let(question)?.also { pauseNanos = SHORTEST_PAUSE_NANOS }
    } catch (e: SourceException) {
        fail(e)
        null
    }

    private fun opened(): ColorPoses.Tracker? {
        if (tracker == null && clock.nowNanos() >= openFromNanos) {
            tracker = poses.open()
            // A device without the library gets none later
            if (tracker == null) openFromNanos = Long.MAX_VALUE
        }
        return tracker
    }

    private fun fail(cause: SourceException) {
        openFromNanos = clock.nowNanos() + pauseNanos
        Log.w("ml2s", "colour images have no pose; asked again in ${pauseNanos / NANOS_PER_MILLI} ms: ${cause.message}")
        pauseNanos = minOf(2 * pauseNanos, LONGEST_PAUSE_NANOS)
        try {
            close()
        } catch (e: SourceException) {
            Log.w("ml2s", "the failed pose tracker of the colour camera cannot be closed: ${e.message}")
        }
    }

    override fun close() {
        val closing = tracker
        tracker = null
        closing?.close()
    }

    private companion object {
        const val NANOS_PER_MILLI = 1_000_000L
        const val SHORTEST_PAUSE_NANOS = 500 * NANOS_PER_MILLI
        const val LONGEST_PAUSE_NANOS = 8_000 * NANOS_PER_MILLI
    }
}
