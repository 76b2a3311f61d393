package dev.ml2sensors.pacing

import kotlin.math.max
import kotlin.math.min

/**
 * How long a small message waits in the link's queue: what the path took of a round trip, less the least round trip of
 * the last 10 s. Not thread-safe.
 */
internal class QueueingDelay {
    private val leastOfSecond = LongArray(SECONDS) { Long.MAX_VALUE }
    private var second = 0L

    /** How many successive round trips had half of the tolerated delay or more. */
    private var queued = 0

    /** The delay of the last round trip, in ns; 0 after [restart]. */
    var lastNanos: Long = 0
        private set

    /** The least round trip of the last 10 s; 0 before the first. */
    val leastRoundTripNanos: Long get() = leastOfSecond.min().let { if (it == Long.MAX_VALUE) 0 else it }

    /** A delay above it is a queue of images. */
    val toleratedNanos: Long get() = max(TOLERATED_NANOS, leastRoundTripNanos / TOLERATED_PART)

    /** True if several round trips have had much of the tolerated delay. */
    val isLasting: Boolean get() = queued >= LASTING

    /** Adds a round trip that ended at [nowNanos], whether or not images were before it on the path. */
    fun addRoundTrip(nanos: Long, nowNanos: Long) {
        val now = nowNanos / SECOND_NANOS
        repeat((now - second).coerceIn(0L, SECONDS.toLong()).toInt()) {
            leastOfSecond[Math.floorMod(now - it, SECONDS)] = Long.MAX_VALUE
        }
        second = now
        val index = Math.floorMod(now, SECONDS)
        leastOfSecond[index] = min(leastOfSecond[index], nanos)
    }

    /** Returns the delay of the round trip just added, which had images before it and took [onPathNanos] on the path. */
    fun behindImages(onPathNanos: Long): Long {
        lastNanos = max(0, onPathNanos - leastRoundTripNanos)
        queued = if (lastNanos > toleratedNanos / 2) queued + 1 else 0
        return lastNanos
    }

    /** The next delay is judged without the last one: the rate has changed. */
    fun restart() {
        lastNanos = 0
    }

    /** Takes [delayNanos] of the delay for the path's own. */
    fun accept(delayNanos: Long, nowNanos: Long) {
        val least = leastRoundTripNanos + delayNanos
        leastOfSecond.fill(Long.MAX_VALUE)
        addRoundTrip(least, nowNanos)
    }

    private companion object {
        const val SECONDS = 10
        const val SECOND_NANOS = 1_000_000_000L

        /** Measured: the queue grows to twice this until two round trips have shown it, and samples may be 15 ms late. */
        const val TOLERATED_NANOS = 6_000_000L
        const val TOLERATED_PART = 8
        const val LASTING = 3
    }
}
