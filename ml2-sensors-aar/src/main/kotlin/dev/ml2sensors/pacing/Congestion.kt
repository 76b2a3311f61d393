package dev.ml2sensors.pacing

import kotlin.math.max
import kotlin.math.pow

/**
 * Several cuts of the rate against one delay. Immutable.
 *
 * @param bytesPerSecond the rate after the first cut, in B/s.
 * @param delayNanos the greatest delay.
 * @param isMeasured true if images without pauses showed what the link delivers.
 */
internal class Congestion(
    val bytesPerSecond: Double,
    private val delayNanos: Long,
    val isMeasured: Boolean,
    private val cuts: Int = 1,
) {
    /** True if so many cuts have not halved the delay: it has another cause than images. */
    fun isElsewhere(delayNanos: Long): Boolean = cuts == MOST_CUTS && delayNanos > this.delayNanos / 2

    /** The rate after a further cut, in B/s; [deliveredRate] is null if images with pauses do not show it. */
    fun furtherRate(deliveredRate: Double?): Double {
        val most = max(GrowingRate.LEAST, bytesPerSecond * FURTHER_CUT.pow(cuts))
        return deliveredRate?.coerceIn(most / DEEPEST_FURTHER_CUT, most) ?: most
    }

    /** This congestion after a further cut. */
    fun further(delayNanos: Long): Congestion =
        Congestion(bytesPerSecond, max(this.delayNanos, delayNanos), isMeasured, cuts + 1)

    private companion object {
        const val FURTHER_CUT = 0.8
        const val DEEPEST_FURTHER_CUT = 2
        const val MOST_CUTS = 4
    }
}
