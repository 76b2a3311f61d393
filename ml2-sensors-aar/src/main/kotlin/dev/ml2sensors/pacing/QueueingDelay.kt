package dev.ml2sensors.pacing

import kotlin.math.max
import kotlin.math.min

/**
 * Estimates the time that a small message waits in the link's queue. It is what the path took of a round trip, less the
 * least round trip of the last 10 s. Where the time of the way to the receiver is known, it is at most that time, less
 * its own least of the last 10 s: a queue on the way back delays no message to the receiver. Not thread-safe.
 */
internal class QueueingDelay {
    private val roundTrips = LeastOfSeconds()
    private val waysThere = LeastOfSeconds()

    /** The number of successive round trips that had half of the tolerated delay or more. */
    private var queued = 0

    /** The delay of the last round trip, in ns; 0 after [restart]. */
    var lastNanos: Long = 0
        private set

    /** The last round trip waited so long on its way back, in ns; 0 if that is not known. */
    var returningNanos: Long = 0
        private set

    /** The last way to the receiver, less the least one, in ns; null if it is not known. */
    private var thereNanos: Long? = null

    /** The least round trip of the last 10 s; 0 before the first. */
    val leastRoundTripNanos: Long get() = roundTrips.leastNanos ?: 0

    /** A delay above it is a queue of images. */
    val toleratedNanos: Long get() = max(TOLERATED_NANOS, leastRoundTripNanos / TOLERATED_PART)

    /** True if several round trips have had much of the tolerated delay. */
    val isLasting: Boolean get() = queued >= LASTING

    /**
     * Adds a round trip that ended at [nowNanos], whether or not images were before it on the path.
     *
     * @param thereNanos the time of its way to the receiver; off by a constant at most, null if it is not known.
     */
    fun addRoundTrip(nanos: Long, thereNanos: Long?, nowNanos: Long) {
        roundTrips.add(nanos, nowNanos)
        if (thereNanos != null) waysThere.add(thereNanos, nowNanos)
        this.thereNanos = thereNanos?.let { max(0, it - (waysThere.leastNanos ?: it)) }
        returningNanos = this.thereNanos?.let { max(0, nanos - leastRoundTripNanos - it) } ?: 0
    }

    /** Returns the delay of the round trip just added, which had images before it and took [onPathNanos] on the path. */
    fun behindImages(onPathNanos: Long): Long {
        lastNanos = max(0, onPathNanos - leastRoundTripNanos).let { min(it, thereNanos ?: it) }
        queued = if (lastNanos > toleratedNanos / 2) queued + 1 else 0
        return lastNanos
    }

    /** The next delay is judged without the last one: the rate has changed. */
    fun restart() {
        lastNanos = 0
    }

    /** Takes [delayNanos] of the delay for the path's own. */
    fun accept(delayNanos: Long, nowNanos: Long) {
        roundTrips.raise(delayNanos, nowNanos)
        waysThere.raise(delayNanos, nowNanos)
    }

    /** The least of the values of the last 10 s, in ns. */
    private class LeastOfSeconds {
        private val leastOfSecond = LongArray(SECONDS) { Long.MAX_VALUE }
        private var second = 0L

        val leastNanos: Long? get() = leastOfSecond.min().takeIf { it != Long.MAX_VALUE }

        fun add(nanos: Long, nowNanos: Long) {
            val now = nowNanos / SECOND_NANOS
            repeat((now - second).coerceIn(0L, SECONDS.toLong()).toInt()) {
                leastOfSecond[Math.floorMod(now - it, SECONDS)] = Long.MAX_VALUE
            }
            second = now
            val index = Math.floorMod(now, SECONDS)
            leastOfSecond[index] = min(leastOfSecond[index], nanos)
        }

        fun raise(nanos: Long, nowNanos: Long) {
            val raised = (leastNanos ?: return) + nanos
            leastOfSecond.fill(Long.MAX_VALUE)
            add(raised, nowNanos)
        }
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
