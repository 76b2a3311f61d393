package dev.ml2sensors.session

import kotlin.time.Duration
import kotlin.time.Duration.Companion.seconds
import kotlin.time.TimeSource

/**
 * For how long the receiver has sent nothing. One coroutine asks again and again; time in which it could not is not the
 * receiver's silence, since this process stood still and has not read what came meanwhile.
 */
internal class Silence(private val time: TimeSource.WithComparableMarks = TimeSource.Monotonic) {
    @Volatile
    private var received = time.markNow()
    private var known = received
    private var asked = received
    private var counted = Duration.ZERO

    /** Begins anew, with a frame of the receiver. Any thread. */
    fun end() {
        received = time.markNow()
    }

    /** Returns how long it has lasted, but for time in which this process stood still. */
    fun lasted(): Duration {
        val latest = received
        counted = if (latest == known) counted + short(asked.elapsedNow()) else short(latest.elapsedNow())
        known = latest
        asked = time.markNow()
        return counted
    }

    private fun short(passed: Duration) = passed.coerceAtMost(LATE)

    private companion object {
        /** A busy headset asks so late; one that is later has stood still. */
        val LATE = 1.seconds
    }
}
