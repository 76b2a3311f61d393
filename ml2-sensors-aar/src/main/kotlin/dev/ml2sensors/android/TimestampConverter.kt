package dev.ml2sensors.android

import dev.ml2sensors.source.ClockDomain
import dev.ml2sensors.source.SourceException
import kotlin.math.abs

/**
 * Converts the timestamps of one sensor to the device timebase. Called when a reading arrives, by the thread that it
 * arrives on. Android documents [ClockDomain.BOOTTIME] for sensor events, which is unconfirmed for this headset, so the
 * clock is determined from the timestamps.
 *
 * A clock is possible if the reading's age by that clock is in [PLAUSIBLE_AGE_NANOS]; some drivers stamp slightly
 * ahead. If both clocks are possible, the one with the smaller age is chosen. A choice holds for its own reading, and for
 * all later ones once [CERTAIN] readings in a row have led to it: a single one may be as old as the device was suspended.
 * Clocks less than [INDISTINGUISHABLE_NANOS] apart, which they are until the device is first suspended, count as
 * [ClockDomain.BOOTTIME]; that difference bounds the error. When a suspension has moved them apart, the clock is
 * determined again. A reading from before the suspension would then look like a fresh one of the other clock, so
 * readings that arrive within [SETTLING_NANOS] after it are lost.
 *
 * @param isOnChange true for a sensor whose reading may be of any age. While its clock is unknown, it is as documented.
 * @param onFound receives the clock when it is determined.
 */
internal class TimestampConverter(
    private val clocks: SystemClocks,
    private val isOnChange: Boolean = false,
    private val onFound: (ClockDomain) -> Unit = {},
) {
    private val offset = MonotonicOffset(clocks)

    /** The clock by the latest reading that told one, and how many in a row told it. */
    private var told: ClockDomain? = null
    private var timesTold = 0
    private var lastTimestamp = Long.MIN_VALUE

    /** The clock that is in use. */
    private var base: ClockDomain? = null
    private var isGuessed = false
    private var decideFromNanos = Long.MIN_VALUE
    private var undecided = 0

    /**
     * Returns the capture time of a reading, or null while its clock is unknown: such a reading is counted as lost.
     *
     * @throws SourceException after [UNDECIDED_LIMIT] timestamps that fit neither clock.
     */
    fun captureNanos(timestamp: Long): Long? {
        val offsetNanos = offset.nanos()
        if (isGuessed && abs(offsetNanos) >= INDISTINGUISHABLE_NANOS) {
            base = null
            timesTold = 0
            isGuessed = false
            decideFromNanos = clocks.boot.nowNanos() + SETTLING_NANOS
        }
        if (timesTold < CERTAIN) listen(timestamp, offsetNanos)
        return when (base ?: documented(timestamp, offsetNanos)) {
            ClockDomain.BOOTTIME -> timestamp
            ClockDomain.MONOTONIC -> timestamp + offsetNanos
            else -> null
        }
    }

    /** Takes note of the clock that [timestamp] tells, if it tells one. */
    private fun listen(timestamp: Long, offsetNanos: Long) {
        val found = find(timestamp, offsetNanos) ?: return
        if (timestamp == lastTimestamp) return
        lastTimestamp = timestamp
        timesTold = if (found == told) timesTold + 1 else 1
        told = found
        // An old reading of the documented clock looks like a fresh one of the other
        if (isOnChange && found == ClockDomain.MONOTONIC && timesTold < CERTAIN) return
        if (found == base) return
        base = found
        isGuessed = abs(offsetNanos) < INDISTINGUISHABLE_NANOS
        onFound(found)
    }

    /** Returns the documented clock for a reading of any age, or null; throws if no reading has told a clock for long. */
    private fun documented(timestamp: Long, offsetNanos: Long): ClockDomain? {
        val bootNanos = clocks.boot.nowNanos()
        if (isOnChange && timestamp > 0 &&
            bootNanos - timestamp >= PLAUSIBLE_AGE_NANOS.first
        ) {
            return ClockDomain.BOOTTIME
        }
        if (bootNanos < decideFromNanos || ++undecided < UNDECIDED_LIMIT) return null
        throw SourceException(
            "expected timestamps within a second of CLOCK_BOOTTIME ($bootNanos) or CLOCK_MONOTONIC " +
                "(${bootNanos - offsetNanos}), found $timestamp",
        )
    }

    private fun find(timestamp: Long, offsetNanos: Long): ClockDomain? {
        val bootNanos = clocks.boot.nowNanos()
        if (bootNanos < decideFromNanos) return null
        val monotonicNanos = bootNanos - offsetNanos
        val bootAge = (bootNanos - timestamp).takeIf { it in PLAUSIBLE_AGE_NANOS }
        val monotonicAge = (monotonicNanos - timestamp).takeIf { it in PLAUSIBLE_AGE_NANOS }
        return when {
            bootAge != null && (monotonicAge == null || bootAge - monotonicAge < INDISTINGUISHABLE_NANOS) ->
                ClockDomain.BOOTTIME

            else -> monotonicAge?.let { ClockDomain.MONOTONIC }
        }
    }

    private companion object {
        val PLAUSIBLE_AGE_NANOS = -5_000_000L..1_000_000_000L
        const val INDISTINGUISHABLE_NANOS = 1_000_000L
        const val UNDECIDED_LIMIT = 100

        /** More than an app gets at once when it registers. */
        const val CERTAIN = 3

        /** Far longer than a reading waits in an unbatched sensor's queue once the processor runs again. */
        const val SETTLING_NANOS = 100_000_000L
    }
}
