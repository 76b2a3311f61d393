package dev.ml2sensors.clock

/** The four times of one exchange: [t1] and [t4] on the device's clock, [t2] and [t3] in the host's ROS time, all ns. */
internal class TimeExchange(private val t1: Long, private val t2: Long, private val t3: Long, val t4: Long) {
    val roundTripNanos: Long get() = (t4 - t1) - (t3 - t2)

    /** Host minus device; off by at most half the round trip. */
    val offsetNanos: Long get() = (t2 - t1) + ((t3 - t4) - (t2 - t1)) / 2
}
