package dev.ml2sensors.stream

import kotlin.time.Duration
import kotlin.time.Duration.Companion.milliseconds
import kotlin.time.Duration.Companion.seconds
import kotlin.time.TimeSource

/**
 * The pauses between attempts. Failed attempts begin at least one period apart, which doubles from [shortest] up to
 * [longest]. So the next attempt follows at once after one that took longer, such as a search or a lost session. Used
 * by one coroutine.
 */
internal class BackOff(
    private val time: TimeSource = TimeSource.Monotonic,
    private val shortest: Duration = 50.milliseconds,
    private val longest: Duration = 1.seconds,
) {
    private var period = shortest
    private var began = time.markNow()

    /** Marks the start of an attempt. */
    fun begin() {
        began = time.markNow()
    }

    /** Marks the attempt as successful: the next pause is short again. */
    fun succeeded() {
        period = shortest
    }

    /** Marks the end of the attempt and returns how long to wait before the next. */
    fun pause(): Duration {
        val pause = (period - began.elapsedNow()).coerceAtLeast(Duration.ZERO)
        period = minOf(period * 2, longest)
        return pause
    }
}
