package dev.ml2sensors.android

import dev.ml2sensors.source.SourceException

/**
 * The clock that a sensor stamps its readings with. Android promises [BOOTTIME] for sensor events; nobody has confirmed
 * it for this headset, so it is found out from the readings themselves.
 */
public enum class TimestampBase {
    /** SystemClock.elapsedRealtimeNanos, CLOCK_BOOTTIME: counts while suspended. */
    BOOTTIME,

    /** System.nanoTime, CLOCK_MONOTONIC: stands still while suspended. */
    MONOTONIC,
}

/**
 * Takes the timestamps of one sensor to the device timebase. Called by the thread they arrive on, at arrival.
 *
 * A timestamp can be of a clock when by that clock it lies in the last [PLAUSIBLE_AGE_NANOS]. If it can be of both, the
 * younger reading decides. Clocks that are less than [INDISTINGUISHABLE_NANOS] apart count as one, [TimestampBase.BOOTTIME]; the
 * error is at most that.
 *
 * @param onFound is told the base, once.
 */
internal class TimestampConverter(private val clocks: SystemClocks, private val onFound: (TimestampBase) -> Unit = {}) {
    private val offset = MonotonicOffset(clocks)
    private var base: TimestampBase? = null
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
            TimestampBase.BOOTTIME -> timestamp
            TimestampBase.MONOTONIC -> timestamp + offset.nanos()
            null -> null
        }
    }

    private fun find(timestamp: Long): TimestampBase? {
        val bootNanos = clocks.boot.nowNanos()
        val monotonicNanos = bootNanos - offset.nanos()
        val bootAge = (bootNanos - timestamp).takeIf { it in PLAUSIBLE_AGE_NANOS }
        val monotonicAge = (monotonicNanos - timestamp).takeIf { it in PLAUSIBLE_AGE_NANOS }
        return when {
            bootAge != null && (monotonicAge == null || bootAge - monotonicAge < INDISTINGUISHABLE_NANOS) ->
                TimestampBase.BOOTTIME

            monotonicAge != null -> TimestampBase.MONOTONIC

            ++undecided < UNDECIDED_LIMIT -> null

            else -> throw SourceException(
                "expected timestamps within a second of CLOCK_BOOTTIME ($bootNanos) or CLOCK_MONOTONIC " +
                    "($monotonicNanos), found $timestamp",
            )
        }
    }

    private companion object {
        val PLAUSIBLE_AGE_NANOS = 0L..1_000_000_000L
        const val INDISTINGUISHABLE_NANOS = 1_000_000L
        const val UNDECIDED_LIMIT = 100
    }
}
