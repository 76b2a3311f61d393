package dev.ml2sensors.clock

import kotlin.math.abs
import kotlin.math.ceil
import kotlin.math.roundToLong

/**
 * Estimates offset and skew at [nowNanos] from bounds on the offset, which is assumed to grow at a steady rate.
 *
 * Upper and lower bounds are two clouds of points over time; queueing moves points only away from the true offset. As
 * with the lower envelope of Moon, Skelly and Towsley (Estimation and removal of clock skew from network delay
 * measurements, INFOCOM 1999), but for both directions: the skew is that of the widest straight corridor between the
 * clouds, and the offset is its middle. With the ages a_i in seconds and the skew s:
 *
 *     above(s) = min (most_i + (s + W) a_i)
 *     below(s) = max (least_i + (s - W) a_i)
 *     skew = argmax (above(s) - below(s) - P |s - likely|)
 *     offset = (above(skew) + below(skew)) / 2
 *
 * The uncertainty makes no assumption about the delays: it covers every offset with any rate that passes between all
 * bounds, [slowestPpb] to [fastestPpb]. It is at least half the least round trip (RFC 5905, 4).
 *
 * @param bounds in order of time, not empty.
 */
internal class OffsetFit(private val bounds: List<TightestBounds>, private val nowNanos: Long) {
    // Offsets are taken from one of them, so that doubles hold them to the nanosecond
    private val originNanos = bounds.last().above.mostOffsetNanos
    private val most = DoubleArray(bounds.size) { (bounds[it].above.mostOffsetNanos - originNanos).toDouble() }
    private val mostAge = DoubleArray(bounds.size) { (nowNanos - bounds[it].above.t1) * 1e-9 }
    private val least = DoubleArray(bounds.size) { (bounds[it].below.leastOffsetNanos - originNanos).toDouble() }
    private val leastAge = DoubleArray(bounds.size) { (nowNanos - bounds[it].below.t4) * 1e-9 }
    private var slowestPpb = -MAX_SKEW_PPB
    private var fastestPpb = MAX_SKEW_PPB

    init {
        for (i in most.indices) for (j in least.indices) narrowSkew(i, j)
    }

    /**
     * Returns the estimate at [nowNanos].
     *
     * @param likelySkewPpb the skew that is used until bounds far enough apart contradict it.
     */
    fun fit(likelySkewPpb: Long): OffsetEstimate {
        val skew = skewPpb(likelySkewPpb)
        val offset = (above(skew) + below(skew)) / 2
        val roundTripNanos = bounds.minOf { it.roundTripNanos }
        val uncertainty = maxOf(above(fastestPpb) - offset, offset - below(slowestPpb), roundTripNanos / 2.0)
        val drift = maxOf(fastestPpb - skew, skew - slowestPpb, 0.0) + WANDER_PPB
        return OffsetEstimate(
            originNanos + offset.roundToLong(),
            ceil(uncertainty).toLong() + 1,
            skew.roundToLong(),
            ceil(drift).toLong() + 1,
            roundTripNanos,
            nowNanos,
        )
    }

    /** Narrows the range of rates to those at which the offset stays below bound [i] and above bound [j]. */
    private fun narrowSkew(i: Int, j: Int) {
        val difference = most[i] - least[j] + WANDER_PPB * (mostAge[i] + leastAge[j])
        val apart = leastAge[j] - mostAge[i]
        if (apart > 0) fastestPpb = minOf(fastestPpb, difference / apart)
        if (apart < 0) slowestPpb = maxOf(slowestPpb, difference / apart)
    }

    private fun above(skewPpb: Double): Double =
        most.indices.minOf { most[it] + (skewPpb + WANDER_PPB) * mostAge[it] }

    private fun below(skewPpb: Double): Double =
        least.indices.maxOf { least[it] + (skewPpb - WANDER_PPB) * leastAge[it] }

    /** Finds the skew by ternary search: the width is concave. */
    private fun skewPpb(likelyPpb: Long): Double {
        val likely = likelyPpb.toDouble()
        fun score(ppb: Double) = above(ppb) - below(ppb) - LIKELY_SECONDS * abs(ppb - likely)
        var from = slowestPpb
        var to = fastestPpb
        while (to - from > SEARCHED_PPB) {
            val third = (to - from) / 3
            if (score(from + third) < score(to - third)) from += third else to -= third
        }
        val widest = (from + to) / 2
        return if (score(widest) > score(likely)) widest else likely
    }

    private companion object {
        /** The most that adjtimex(2) lets a host's rate be corrected; crystals are off by 100 ppm at most. */
        const val MAX_SKEW_PPB = 500_000.0

        /** W: 1 ppm, more than what a changing temperature does to two crystals within the seconds that are kept. */
        const val WANDER_PPB = 1_000.0

        /** P: bounds less than about this far apart do not move the skew. */
        const val LIKELY_SECONDS = 0.7
        const val SEARCHED_PPB = 1.0
    }
}
