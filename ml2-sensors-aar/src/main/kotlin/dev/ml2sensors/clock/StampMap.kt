package dev.ml2sensors.clock

import dev.ml2sensors.source.DeviceClock
import dev.ml2sensors.source.DropReason
import kotlin.math.abs

/**
 * The one map of the whole device from capture time to ROS time, a pure function: every message of one capture, and
 * two sensors exposed together, get the same stamp.
 *
 * [steerTo] changes the map for captures later than any asked for before only. What is off by no more than
 * [OffsetEstimator.STEP_NANOS] is slewed, by at most [MAX_SLEW_PPB]. A step back by at most [LONGEST_WAIT_NANOS] leaves
 * captures without a stamp until ROS time has passed all earlier stamps; any other step begins a new [epoch]. So within
 * an epoch the stamps of captures at least 2 ns apart grow. A capture in the future, whose stamp would keep the map from
 * being steered until then, is given none. Safe for use by several threads.
 */
internal class StampMap(private val deviceClock: DeviceClock) {
    private var segments: List<Segment> = emptyList()
    private var latestCaptureNanos = Long.MIN_VALUE
    private var frozen = false

    /** How often stamps have jumped, by a new epoch each. */
    var epoch = 0L
        @Synchronized get
        private set

    /** False until the first offset is known. */
    val isSet: Boolean @Synchronized get() = segments.isNotEmpty()

    /** ROS time in ns of a capture on the device timebase, null when [lossReason] withholds it. The map must be set. */
    @Synchronized
    fun stampNanos(captureNanos: Long): Long? {
        if (isFuture(captureNanos)) return null
        val segment = segmentOf(captureNanos)
        latestCaptureNanos = maxOf(latestCaptureNanos, captureNanos)
        return (captureNanos + segment.offsetNanos(captureNanos)).takeIf { it > segment.floorNanos }
    }

    /** Whether a capture is later than any can be; a recording's, which a frozen map stamps, may be at any time. */
    @Synchronized
    fun isFuture(captureNanos: Long): Boolean = !frozen && captureNanos > deviceClock.nowNanos() + MOST_AHEAD_NANOS

    /** Why there is no stamp for a capture. */
    fun lossReason(captureNanos: Long): DropReason =
        if (isFuture(captureNanos)) DropReason.FUTURE_CAPTURE else DropReason.CLOCK_STEP

    /** How far the map is from [offsetNanos] at a device time. The map must be set. */
    @Synchronized
    fun errorNanos(offsetNanos: Long, deviceNanos: Long): Long =
        abs(segmentOf(deviceNanos).offsetNanos(deviceNanos) - offsetNanos)

    /** Sets the first offset, or steers to [offsetNanos], growing by [skewPpb], as of [nowNanos], device time. */
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

    /** Makes the present offset the constant of all captures, earlier ones too: a recording keeps its intervals. */
    @Synchronized
    fun freeze(nowNanos: Long) {
        segments = listOf(Segment(nowNanos, segmentOf(nowNanos).offsetNanos(nowNanos), 0, Long.MIN_VALUE))
        frozen = true
    }

    private fun segmentOf(captureNanos: Long): Segment {
        check(segments.isNotEmpty()) { "no offset to the host is known yet" }
        return segments.lastOrNull { it.startNanos <= captureNanos } ?: segments.first()
    }

    /** Offset [offsetNanos] at [startNanos], growing by [skewPpb]; stamps up to [floorNanos] are not given. */
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

        /** DESIGN, Time: whoever waits longer is told of a new epoch instead. */
        const val LONGEST_WAIT_NANOS = 2_000_000_000L

        /** More than any pose is predicted ahead. */
        const val MOST_AHEAD_NANOS = 1_000_000_000L

        /** Enough for captures that are delivered half a minute late at four updates of two segments per second. */
        const val KEPT_SEGMENTS = 256
    }
}
