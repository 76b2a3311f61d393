package dev.ml2sensors.source

/** The device timebase in nanoseconds: never goes back, counts while suspended (Android: CLOCK_BOOTTIME). */
public fun interface DeviceClock {
    /** Returns the present time; thread-safe. */
    public fun nowNanos(): Long
}
