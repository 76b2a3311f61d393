package dev.ml2sensors.clock

/**
 * Host-minus-device offset from time exchanges: of a sliding window, the exchange with the least round trip, since
 * queueing only ever adds to it. Does no I/O; used by one thread.
 */
internal class OffsetEstimator {
    private val window = ArrayDeque<TimeExchange>()

    /** Takes in one exchange and gives the estimate as of its end. */
    fun add(exchange: TimeExchange): OffsetEstimate {
        window.addLast(exchange)
        while (exchange.t4 - window.first().t4 > WINDOW_NANOS) window.removeFirst()
        val best = window.minBy { it.roundTripNanos + driftNanos(exchange.t4 - it.t4) }
        val uncertaintyNanos = (best.roundTripNanos + 1) / 2 + driftNanos(exchange.t4 - best.t4)
        return OffsetEstimate(best.offsetNanos, uncertaintyNanos, best.roundTripNanos, exchange.t4)
    }

    private fun driftNanos(ageNanos: Long): Long = ageNanos * MAX_DRIFT_PPM / 1_000_000

    private companion object {
        const val WINDOW_NANOS = 5_000_000_000L

        /** How far two crystal clocks may drift apart; 100 ppm is beyond what phones and PCs show. */
        const val MAX_DRIFT_PPM = 100L
    }
}

/**
 * ROS time = device time + [offsetNanos], off by at most [uncertaintyNanos] at device time [atNanos], a constant
 * asymmetry of the path aside.
 */
internal class OffsetEstimate(
    val offsetNanos: Long,
    val uncertaintyNanos: Long,
    val roundTripNanos: Long,
    val atNanos: Long,
)
