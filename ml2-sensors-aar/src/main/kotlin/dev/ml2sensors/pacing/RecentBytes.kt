package dev.ml2sensors.pacing

/** Measures how fast a count of bytes grew in the last 400 ms. */
internal class RecentBytes {
    /** The count at a time, and its rate in the time before, [BURST_NANOS] or a little more, in B/s. */
    private class Total(val bytes: Long, val atNanos: Long, val burst: Double)

    private val totals = ArrayDeque<Total>()

    /** The greatest rate over 20 ms or more, in B/s: between bursts of images the link is idle. */
    val mostBytesPerSecond: Double get() = totals.maxOfOrNull { it.burst } ?: 0.0

    /** Adds the count of [bytes] until [nowNanos]. */
    fun add(bytes: Long, nowNanos: Long) {
        val last = totals.lastOrNull()
        if (last != null && nowNanos - last.atNanos < INTERVAL_NANOS) return
        val most = maxOf(bytes, last?.bytes ?: 0)
        val before = totals.lastOrNull { nowNanos - it.atNanos >= BURST_NANOS }
        totals.addLast(Total(most, nowNanos, before?.let { rate(it, most, nowNanos) } ?: 0.0))
        while (nowNanos - totals.first().atNanos > WINDOW_NANOS) totals.removeFirst()
    }

    /** The rate of the last [windowNanos], in B/s; 0 if it is not known. */
    fun bytesPerSecond(windowNanos: Long): Double {
        val last = totals.lastOrNull() ?: return 0.0
        val first = totals.firstOrNull { last.atNanos - it.atNanos <= windowNanos } ?: last
        return if (first === last) 0.0 else rate(first, last.bytes, last.atNanos)
    }

    private fun rate(first: Total, bytes: Long, atNanos: Long) = (bytes - first.bytes) * 1e9 / (atNanos - first.atNanos)

    private companion object {
        const val WINDOW_NANOS = 400_000_000L
        const val INTERVAL_NANOS = 2_000_000L
        const val BURST_NANOS = 20_000_000L
    }
}
