package dev.ml2sensors.pacing

import kotlin.math.min

/** The least of the round trips of the last 10 s. */
internal class LeastRoundTrip {
    private val leastOfSecond = LongArray(SECONDS) { Long.MAX_VALUE }
    private var second = 0L

    val leastNanos: Long get() = leastOfSecond.min().let { if (it == Long.MAX_VALUE) 0 else it }

    fun add(nanos: Long, nowNanos: Long) {
        val now = nowNanos / SECOND_NANOS
        repeat((now - second).coerceIn(0L, SECONDS.toLong()).toInt()) {
            leastOfSecond[Math.floorMod(now - it, SECONDS)] = Long.MAX_VALUE
        }
        second = now
        val index = Math.floorMod(now, SECONDS)
        leastOfSecond[index] = min(leastOfSecond[index], nanos)
    }

    /** Forgets everything but [nanos]. */
    fun restart(nanos: Long, nowNanos: Long) {
        leastOfSecond.fill(Long.MAX_VALUE)
        add(nanos, nowNanos)
    }

    private companion object {
        const val SECONDS = 10
        const val SECOND_NANOS = 1_000_000_000L
    }
}
