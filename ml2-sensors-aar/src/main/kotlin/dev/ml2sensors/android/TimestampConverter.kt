package dev.ml2sensors.android

import dev.ml2sensors.source.ClockDomain
import dev.ml2sensors.source.SourceException

/**
 * Takes the timestamps of one sensor to the device timebase. Called by the thread they arrive on, at arrival. Android
 * promises [ClockDomain.BOOTTIME] for sensor events; nobody has confirmed it for this headset, so the clock is found out
 * from the timestamps themselves.
 *
 * A timestamp can be of a clock when by that clock its age is in [PLAUSIBLE_AGE_NANOS]: some drivers stamp a little ahead. If it can be of both, the
 * younger reading decides. Clocks that are less than [INDISTINGUISHABLE_NANOS] apart count as one, [ClockDomain.BOOTTIME]; the
 * error is at most that.
 *
 * @param onFound is told the base, once.
 */
internal class TimestampConverter(private val clocks: SystemClocks, private val onFound: (ClockDomain) -> Unit = {}) {
    private val offset = MonotonicOffset(clocks)
    private var base: ClockDomain? = null
    private var undecided = 0

    /**
     * The capture time of a reading, null while its clock is not known: then it cannot be stamped and is lost.
     *
     * @throws SourceException after [UNDECIDED_LIMIT] timestamps that can be of neither clock.
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
