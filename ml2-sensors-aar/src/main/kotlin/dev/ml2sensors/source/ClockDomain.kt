package dev.ml2sensors.source

/**
 * The clocks a capture time may come from. Every source converts to the device timebase, [BOOTTIME], before it delivers
 * a [Sample]; the host's clock is reached from there alone, so the errors below add up to that of a stamp.
 *
 * @property wireName as in STATUS, PROTOCOL.md.
 */
public enum class ClockDomain(public val wireName: String) {
    /**
     * CLOCK_BOOTTIME, `SystemClock.elapsedRealtimeNanos`: counts while suspended. What Android documents for
     * `SensorEvent.timestamp`, and for Camera2 where SENSOR_INFO_TIMESTAMP_SOURCE is REALTIME. Needs no conversion;
     * good to the resolution of the driver's stamp.
     */
    BOOTTIME("boottime"),

    /**
     * CLOCK_MONOTONIC, `System.nanoTime`: the same oscillator, but stands still while suspended. To [BOOTTIME] by
     * readings of the one between two of the other, accurate to half the bracket, below a microsecond when idle.
     * Measured again at every conversion (Android's sensors) or once a second (native sources), so after a resume at
     * most the next second is converted by the offset from before.
     */
    MONOTONIC("monotonic"),

    /**
     * MLTime of the vendor's SDK, and XrTime: nanoseconds from an origin that is not promised. Stamps depth, world and
     * eye frames and the centre of exposure of the colour camera. The vendor's own conversion goes to [MONOTONIC], and
     * its accuracy is not stated; from there on as above.
     */
    MLTIME("mltime"),

    /**
     * CLOCK_REALTIME of the host, ROS time, set by the host's administrator. Known through time exchanges, accurate to
     * the `uncertainty_ns` of STATUS, which is at least half the least round trip.
     */
    REALTIME("realtime"),
}

/** The device timebase in nanoseconds: never goes back, counts while suspended (Android: CLOCK_BOOTTIME). */
public fun interface DeviceClock {
    /** Returns the present time; thread-safe. */
    public fun nowNanos(): Long
}
