package dev.ml2sensors.pacing

import kotlin.math.cbrt
import kotlin.math.pow

/**
 * The growth of a rate after congestion, in parts of the congested rate and in the shape of CUBIC (RFC 9438, 4.2):
 * quickly from [CUT], then slowly near the congested rate, then faster.
 */
internal object CubicGrowth {
    private const val CUT = 0.85
    private const val PLATEAU = 0.95
    private const val PLATEAU_SECONDS = 1.0
    private const val DOUBLING_SECONDS = 0.4

    /** The part up to which the rate grows slowly. */
    const val PLATEAU_END: Double = 1.1

    /** The time at which the rate reaches [PLATEAU_END]. */
    val PLATEAU_END_SECONDS: Double = PLATEAU_SECONDS * (1 + cbrt((PLATEAU_END - PLATEAU) / (PLATEAU - CUT)))

    /** Returns the part of the congested rate after [seconds] of growth. */
    fun part(seconds: Double): Double {
        val beyond = seconds - PLATEAU_END_SECONDS
        if (beyond > 0) return PLATEAU_END * 2.0.pow(beyond / DOUBLING_SECONDS)
        return PLATEAU + (PLATEAU - CUT) * (seconds / PLATEAU_SECONDS - 1).pow(3)
    }
}
