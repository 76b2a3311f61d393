package dev.ml2sensors.clock

/**
 * ROS time = device time + [offsetNanos] at device time [atNanos], off by at most [uncertaintyNanos]; an asymmetry of
 * the path cannot be seen, but is within that too.
 *
 * @property skewPpb by how much the offset grows, ns per second.
 * @property driftPpb by how much the uncertainty grows without further exchanges, ns per second.
 * @property roundTripNanos the least of the window.
 */
internal class OffsetEstimate(
    val offsetNanos: Long,
    val uncertaintyNanos: Long,
    val skewPpb: Long,
    val driftPpb: Long,
    val roundTripNanos: Long,
    val atNanos: Long,
) {
    fun offsetNanos(deviceNanos: Long): Long = offsetNanos + elapsed(deviceNanos, skewPpb)

    fun uncertaintyNanos(deviceNanos: Long): Long =
        uncertaintyNanos + elapsed(maxOf(deviceNanos, atNanos), driftPpb)

    /** Returns true if no offset within the uncertainty can explain [exchange]. */
    fun isContradictedBy(exchange: TimeExchange): Boolean {
        val offset = offsetNanos(exchange.t4)
        val uncertainty = uncertaintyNanos(exchange.t4)
        return exchange.mostOffsetNanos - offset < -uncertainty || exchange.leastOffsetNanos - offset > uncertainty
    }

    private fun elapsed(deviceNanos: Long, ppb: Long): Long = ((deviceNanos - atNanos) * 1e-9 * ppb).toLong()
}
