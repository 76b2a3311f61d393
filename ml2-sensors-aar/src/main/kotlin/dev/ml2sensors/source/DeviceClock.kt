package dev.ml2sensors.source

/** The device timebase in nanoseconds: never goes back, counts while suspended (Android: CLOCK_BOOTTIME). */
public fun interface DeviceClock {
    /** Of this instant; any thread. */
    public fun nowNanos(): Long
}
