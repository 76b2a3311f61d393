package dev.ml2sensors.clock

/**
 * The one map of the whole device from capture time to ROS time, a pure function: every message of one capture, and
 * two sensors exposed together, get the same stamp.
 *
 * [steerTo] changes the map for captures later than any stamped before only, at no more than [MAX_SLEW_PPB], so stamps
 * of captures at least 2 ns apart always grow. Safe for use by several threads.
 */
internal class StampMap {
    private var segments: List<Segment> = emptyList()
    private var latestCaptureNanos = Long.MIN_VALUE
    private var frozen = false

    /** False until the first offset is known. */
    val isSet: Boolean @Synchronized get() = segments.isNotEmpty()

    /** ROS time in ns of a capture on the device timebase. The map must be set. */
    @Synchronized
    fun stampNanos(captureNanos: Long): Long {
        check(segments.isNotEmpty()) { "no offset to the host is known yet" }
        latestCaptureNanos = maxOf(latestCaptureNanos, captureNanos)
        val segment = segments.lastOrNull { it.startNanos <= captureNanos } ?: segments.first()
        return captureNanos + segment.offsetNanos(captureNanos)
    }

    /** Sets the first offset, or steers towards [offsetNanos] from [nowNanos], device time, on. */
    @Synchronized
    fun steerTo(offsetNanos: Long, nowNanos: Long) {
        if (frozen) return
        val last = segments.lastOrNull()
        if (last == null) {
            segments = listOf(Segment(nowNanos, nowNanos, offsetNanos, 0))
            return
        }
        val start = maxOf(nowNanos, last.startNanos, latestCaptureNanos) + 1
        val here = last.offsetNanos(start)
        val error = offsetNanos - here
        val slewPpb = error.coerceIn(-MAX_SLEW_PPB, MAX_SLEW_PPB)
        val durationSeconds = if (slewPpb == 0L) 0 else (error / slewPpb).coerceAtMost(LONGEST_SLEW_SECONDS)
        val end = start + durationSeconds * NANOS_PER_SECOND
        segments = segments.takeLast(KEPT_SEGMENTS - 1) + Segment(start, end, here, slewPpb)
    }

    /** Makes the present offset the constant of all captures, earlier ones too: a recording keeps its intervals. */
    @Synchronized
    fun freeze(nowNanos: Long) {
        check(segments.isNotEmpty()) { "no offset to the host is known yet" }
        val offset = segments.last().offsetNanos(nowNanos)
        segments = listOf(Segment(nowNanos, nowNanos, offset, 0))
        frozen = true
    }

    /** Offset [startOffsetNanos] at [startNanos], changing by [slewPpb] per second until [endNanos]. */
    private class Segment(val startNanos: Long, val endNanos: Long, val startOffsetNanos: Long, val slewPpb: Long) {
        fun offsetNanos(captureNanos: Long): Long {
            val slewedNanos = (minOf(captureNanos, endNanos) - startNanos).coerceAtLeast(0)
            val seconds = slewedNanos / NANOS_PER_SECOND
            val rest = slewedNanos % NANOS_PER_SECOND
            return startOffsetNanos + seconds * slewPpb + rest * slewPpb / NANOS_PER_SECOND
        }
    }

    private companion object {
        const val NANOS_PER_SECOND = 1_000_000_000L

        /** 500 ppm, the slew limit of adjtime(3): far above any crystal's drift, invisible to consumers. */
        const val MAX_SLEW_PPB = 500_000L

        /** A decade: a host that steps by more than can be caught up with in that is not waited for. */
        const val LONGEST_SLEW_SECONDS = 315_360_000L

        /** Enough for captures that are delivered a minute late at one update per second. */
        const val KEPT_SEGMENTS = 64
    }
}
