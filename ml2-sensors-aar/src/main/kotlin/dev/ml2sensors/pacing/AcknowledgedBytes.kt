package dev.ml2sensors.pacing

/** Measures what the link delivered: the bytes that the receiver acknowledged in the last 400 ms. */
internal class AcknowledgedBytes {
    private class Total(val bytes: Long, val atNanos: Long)

    private val totals = ArrayDeque<Total>()

    /** Adds the count of [bytes] that were acknowledged until [nowNanos]. */
    fun add(bytes: Long, nowNanos: Long) {
        val last = totals.lastOrNull()
        if (last != null && nowNanos - last.atNanos < INTERVAL_NANOS) return
        totals.addLast(Total(maxOf(bytes, last?.bytes ?: 0), nowNanos))
        while (nowNanos - totals.first().atNanos > WINDOW_NANOS) totals.removeFirst()
    }

    /** The rate of the last [windowNanos], in B/s; 0 if it is not known. */
    fun recentBytesPerSecond(windowNanos: Long): Double {
        val last = totals.lastOrNull() ?: return 0.0
        return rate(totals.firstOrNull { last.atNanos - it.atNanos <= windowNanos } ?: last, last)
    }

    /** The greatest rate over 20 ms or more, in B/s: between bursts of images the link is idle. */
    fun mostBytesPerSecond(): Double = totals.maxOfOrNull { first ->
        val next = totals.firstOrNull { it.atNanos - first.atNanos >= BURST_NANOS }
        if (next == null) 0.0 else rate(first, next)
    } ?: 0.0

    private fun rate(first: Total, last: Total) =
        if (last === first) 0.0 else (last.bytes - first.bytes) * 1e9 / (last.atNanos - first.atNanos)

    private companion object {
        const val WINDOW_NANOS = 400_000_000L
        const val INTERVAL_NANOS = 2_000_000L
        const val BURST_NANOS = 20_000_000L
    }
}
