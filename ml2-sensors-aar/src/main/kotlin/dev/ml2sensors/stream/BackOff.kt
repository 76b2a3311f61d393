package dev.ml2sensors.stream

import kotlin.time.Duration
import kotlin.time.Duration.Companion.milliseconds
import kotlin.time.Duration.Companion.seconds
import kotlin.time.TimeSource

/**
 * How often to try again: attempts that fail begin at least a period apart, which doubles from [shortest] up to
 * [longest]. So one that took longer, as the search for a receiver or a session that was lost, is followed by the next
 * at once. Confined to one coroutine.
 */
internal class BackOff(
    private val time: TimeSource = TimeSource.Monotonic,
    private val shortest: Duration = 50.milliseconds,
    private val longest: Duration = 1.seconds,
) {
    private var period = shortest
    private var began = time.markNow()

    /** An attempt begins. */
    fun begin() {
        began = time.markNow()
    }

    /** The attempt has succeeded, whatever becomes of it. */
    fun succeeded() {
        period = shortest
    }

    /** The attempt is over; how long to wait before the next. */
    fun pause(): Duration {
        val pause = (period - began.elapsedNow()).coerceAtLeast(Duration.ZERO)
        period = minOf(period * 2, longest)
        return pause
    }
}
