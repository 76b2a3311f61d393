package dev.ml2sensors.android

import dev.ml2sensors.source.ClockDomain
import dev.ml2sensors.source.SourceException

/**
 * Converts the timestamps of one sensor to the device timebase. Called when a reading arrives, by the thread that it
 * arrives on. Android documents [ClockDomain.BOOTTIME] for sensor events, which is unconfirmed for this headset, so the
 * clock is determined from the timestamps.
 *
 * A clock is possible if the reading's age by that clock is in [PLAUSIBLE_AGE_NANOS]; some drivers stamp slightly
 * ahead. If both clocks are possible, the one with the smaller age is chosen. Clocks less than
 * [INDISTINGUISHABLE_NANOS] apart count as [ClockDomain.BOOTTIME]; that difference bounds the error.
 *
 * @param onFound receives the clock, once.
 */
internal class TimestampConverter(private val clocks: SystemClocks, private val onFound: (ClockDomain) -> Unit = {}) {
    private val offset = MonotonicOffset(clocks)
    private var base: ClockDomain? = null
    private var undecided = 0

    /**
     * Returns the capture time of a reading, or null while its clock is unknown: such a reading is counted as lost.
     *
     * @throws SourceException after [UNDECIDED_LIMIT] timestamps that fit neither clock.
     */
    fun captureNanos(timestamp: Long): Long? {
        val known = base ?: find(timestamp)?.also {
            base = it
            onFound(it)
        }
        return when (known) {
            ClockDomain.BOOTTIME -> timestamp
            ClockDomain.MONOTONIC -> timestamp + offset.nanos()
            else -> null
        }
    }

    private fun find(timestamp: Long): ClockDomain? {
        val bootNanos = clocks.boot.nowNanos()
        val monotonicNanos = bootNanos - offset.nanos()
        val bootAge = (bootNanos - timestamp).takeIf { it in PLAUSIBLE_AGE_NANOS }
        val monotonicAge = (monotonicNanos - timestamp).takeIf { it in PLAUSIBLE_AGE_NANOS }
        return when {
            bootAge != null && (monotonicAge == null || bootAge - monotonicAge < INDISTINGUISHABLE_NANOS) ->
                ClockDomain.BOOTTIME

            monotonicAge != null -> ClockDomain.MONOTONIC

            ++undecided < UNDECIDED_LIMIT -> null

            else -> throw SourceException(
                "expected timestamps within a second of CLOCK_BOOTTIME ($bootNanos) or CLOCK_MONOTONIC " +
                    "($monotonicNanos), found $timestamp",
            )
        }
    }

    private companion object {
        val PLAUSIBLE_AGE_NANOS = -5_000_000L..1_000_000_000L
        const val INDISTINGUISHABLE_NANOS = 1_000_000L
        const val UNDECIDED_LIMIT = 100
    }
}
