package dev.ml2sensors.pacing

import kotlin.math.max
import kotlin.math.min
import kotlin.math.pow

/**
 * A rate that doubles until the link is congested for the first time. Afterwards it first drains the link's queue, and
 * then grows as [CubicGrowth]. Not thread-safe.
 */
internal class GrowingRate(startNanos: Long) {
    /** The rate at which the link is congested, in B/s; null before the first time. */
    var congestedAt: Double? = null
        private set
    private var drainedNanos = startNanos

    /** For how long images have waited since the queue was drained. */
    private var grownNanos = 0L
    private var advancedNanos = startNanos

    /** True if the rate has grown above the congested one. */
    val isBeyond: Boolean get() = congestedAt != null && grownNanos * 1e-9 > CubicGrowth.PLATEAU_END_SECONDS

    /** From now on grows from [bytesPerSecond], once the queue is drained. */
    fun restart(bytesPerSecond: Double, drainedNanos: Long) {
        congestedAt = bytesPerSecond
        this.drainedNanos = drainedNanos
        grownNanos = 0
    }

    /** Grows until [nowNanos]. [slowness] returns by which factor more slowly; null if the rate stays. */
    inline fun advance(nowNanos: Long, slowness: () -> Int?) {
        val from = max(advancedNanos, drainedNanos)
        if (nowNanos > from) slowness()?.let { grownNanos += (nowNanos - from) / it }
        advancedNanos = max(advancedNanos, nowNanos)
    }

    /** Returns the present rate in B/s on a path with [leastRoundTripNanos]. */
    fun bytesPerSecond(leastRoundTripNanos: Long, nowNanos: Long): Double {
        // Congestion shows later on a long path, so that the rate must grow more slowly
        val seconds = grownNanos * 1e-9 / max(1.0, leastRoundTripNanos / SHORT_PATH_NANOS)
        val congestedAt = congestedAt ?: return START * 2.0.pow(seconds / START_DOUBLING_SECONDS)
        return max(LEAST, congestedAt * if (nowNanos < drainedNanos) DRAIN else CubicGrowth.part(seconds))
    }

    /** The part of [rate] that is at most a little above the congested one: the link was seen to have so much. */
    fun proven(rate: Double): Double = min(rate, (congestedAt ?: rate) * CubicGrowth.PLATEAU_END)

    /**
     * Returns the rate of a link that was found congested at [rate] and delivered [deliveredRate], in B/s. Images with
     * pauses, which are not [isFilled], show less than the link delivers, and a single delay may have come from
     * elsewhere: then the known rate stands.
     */
    fun cut(rate: Double, deliveredRate: Double, isFilled: Boolean): Double {
        val known = congestedAt?.takeIf { !isFilled && rate <= it * CubicGrowth.PLATEAU_END } ?: 0.0
        val least = (if (isFilled) proven(rate) else rate) / DEEPEST_CUT
        return max(deliveredRate, known).coerceIn(least, rate)
    }

    companion object {
        /** A picture now and then, on any link, in B/s. */
        const val LEAST: Double = 0.5e6 / 8

        /** In B/s: what a poor Wi-Fi link has left beside small messages. */
        private const val START = 10e6 / 8
        private const val START_DOUBLING_SECONDS = 0.2
        private const val DEEPEST_CUT = 4
        private const val DRAIN = 0.25
        private const val SHORT_PATH_NANOS = 20e6
    }
}
