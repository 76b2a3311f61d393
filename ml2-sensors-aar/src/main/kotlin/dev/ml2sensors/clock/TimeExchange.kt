package dev.ml2sensors.clock

/**
 * The four times of one exchange: [t1] and [t4] on the device's clock, t2 and t3 in the host's ROS time, all ns.
 *
 * Nothing arrives before it is sent, so t1 + offset <= t2 and t3 <= t4 + offset: two bounds that hold whatever the path
 * does.
 */
internal class TimeExchange(val t1: Long, t2: Long, t3: Long, val t4: Long) {
    /** Host minus device at [t1] is at most this. */
    val mostOffsetNanos: Long = t2 - t1

    /** Host minus device at [t4] is at least this. */
    val leastOffsetNanos: Long = t3 - t4

    val roundTripNanos: Long get() = mostOffsetNanos - leastOffsetNanos
}
