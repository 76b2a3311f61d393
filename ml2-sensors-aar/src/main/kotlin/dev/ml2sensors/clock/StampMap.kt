package dev.ml2sensors.clock

import dev.ml2sensors.source.DeviceClock
import dev.ml2sensors.source.DropReason
import kotlin.math.abs

/**
 * The map from capture time to ROS time, one for the whole device. It is a pure function: every message of one capture,
 * and sensors exposed together, get the same stamp.
 *
 * [steerTo] changes the map only for captures later than every one stamped so far. An error of at most
 * [OffsetEstimator.STEP_NANOS] is slewed away, by at most [MAX_SLEW_PPB]. After a backward step of at most
 * [LONGEST_WAIT_NANOS], captures get no stamp until ROS time has passed all earlier stamps. Any other step starts a new
 * [epoch]. So within an epoch, the stamps of captures at least 2 ns apart increase. A capture in the future gets no
 * stamp, since it would block steering until then. Thread-safe.
 */
internal class StampMap(private val deviceClock: DeviceClock) {
    private var segments: List<Segment> = emptyList()
    private var latestCaptureNanos = Long.MIN_VALUE
    private var frozen = false

    /** The number of jumps of the stamps. */
    var epoch = 0L
        @Synchronized get
        private set

    /** False until the first offset is known. */
    val isSet: Boolean @Synchronized get() = segments.isNotEmpty()

    /**
     * Returns the ROS time in ns of a capture on the device timebase, or null for a [lossReason]. The map must be set.
     */
    @Synchronized
    fun stampNanos(captureNanos: Long): Long? {
        if (isFuture(captureNanos)) return null
        val segment = segmentOf(captureNanos)
        latestCaptureNanos = maxOf(latestCaptureNanos, captureNanos)
        return (captureNanos + segment.offsetNanos(captureNanos)).takeIf { it > segment.floorNanos }
    }

    /**
     * Returns true if a capture is more than [MOST_AHEAD_NANOS] ahead of the clock. Always false once the map is
     * frozen, since a recording's captures may be at any time.
     */
    @Synchronized
    fun isFuture(captureNanos: Long): Boolean = !frozen && captureNanos > deviceClock.nowNanos() + MOST_AHEAD_NANOS

    /** Returns why a capture has no stamp. */
    fun lossReason(captureNanos: Long): DropReason =
        if (isFuture(captureNanos)) DropReason.FUTURE_CAPTURE else DropReason.CLOCK_STEP

    /** Returns the difference between the map and [offsetNanos] at a device time. The map must be set. */
    @Synchronized
    fun errorNanos(offsetNanos: Long, deviceNanos: Long): Long =
        abs(segmentOf(deviceNanos).offsetNanos(deviceNanos) - offsetNanos)

    /** Sets the first offset, or steers to [offsetNanos] at the device time [nowNanos], growing by [skewPpb]. */
    @Synchronized
    fun steerTo(offsetNanos: Long, nowNanos: Long, skewPpb: Long = 0) {
        if (frozen) return
        val target = Segment(nowNanos, offsetNanos, skewPpb, Long.MIN_VALUE)
        if (segments.isEmpty()) {
            segments = listOf(target)
            return
        }
        val start = maxOf(nowNanos, latestCaptureNanos, segments.first().startNanos) + 1
        val begun = segments.filter { it.startNanos < start }.takeLast(KEPT_SEGMENTS)
        segments = begun + towards(target, begun.last(), start)
    }

    private fun towards(target: Segment, last: Segment, start: Long): List<Segment> {
        val here = last.offsetNanos(start)
        val there = target.offsetNanos(start)
        val error = there - here
        return when (error) {
            in -OffsetEstimator.STEP_NANOS..OffsetEstimator.STEP_NANOS -> slew(start, here, error, target.skewPpb, last)

            in -LONGEST_WAIT_NANOS..0 -> {
                val given = start - 1 + last.offsetNanos(start - 1)
                listOf(Segment(start, there, target.skewPpb, maxOf(given, last.floorNanos)))
            }

            else -> {
                epoch++
                listOf(Segment(start, there, target.skewPpb, Long.MIN_VALUE))
            }
        }
    }

    private fun slew(start: Long, here: Long, error: Long, skewPpb: Long, last: Segment): List<Segment> {
        val slewPpb = (error * SLEWS_PER_SECOND).coerceIn(-MAX_SLEW_PPB, MAX_SLEW_PPB)
        if (slewPpb == 0L) return listOf(Segment(start, here, skewPpb, last.floorNanos))
        val slewing = Segment(start, here, skewPpb + slewPpb, last.floorNanos)
        val end = start + error * NANOS_PER_SECOND / slewPpb
        return listOf(slewing, Segment(end, slewing.offsetNanos(end), skewPpb, last.floorNanos))
    }

    /** Applies the present offset to all captures, earlier ones too: a recording keeps its intervals. */
    @Synchronized
    fun freeze(nowNanos: Long) {
        segments = listOf(Segment(nowNanos, segmentOf(nowNanos).offsetNanos(nowNanos), 0, Long.MIN_VALUE))
        frozen = true
    }

    private fun segmentOf(captureNanos: Long): Segment {
        check(segments.isNotEmpty()) { "no offset to the host is known yet" }
        return segments.lastOrNull { it.startNanos <= captureNanos } ?: segments.first()
    }

    /** The offset [offsetNanos] at [startNanos], growing by [skewPpb]; stamps up to [floorNanos] are withheld. */
    private class Segment(
        val startNanos: Long,
        val offsetNanos: Long,
        val skewPpb: Long,
        val floorNanos: Long,
    ) {
        fun offsetNanos(captureNanos: Long): Long {
            val elapsed = captureNanos - startNanos
            val seconds = elapsed / NANOS_PER_SECOND
            return offsetNanos + seconds * skewPpb + elapsed % NANOS_PER_SECOND * skewPpb / NANOS_PER_SECOND
        }
    }

    private companion object {
        const val NANOS_PER_SECOND = 1_000_000_000L

        /** 500 ppm, the slew limit of adjtime(3): far above any crystal's drift, invisible to consumers. */
        const val MAX_SLEW_PPB = 500_000L

        /** Small errors are slewed away until the next steering. */
        const val SLEWS_PER_SECOND = 4L

        /** The longest time without stamps; a larger step starts a new epoch. */
        const val LONGEST_WAIT_NANOS = 2_000_000_000L

        /** More than any pose is predicted ahead. */
        const val MOST_AHEAD_NANOS = 1_000_000_000L

        /** Covers captures that are delivered half a minute late, at four updates of two segments per second. */
        const val KEPT_SEGMENTS = 256
    }
}
