package dev.ml2sensors.android

/** Clocks of a device that was suspended for [suspendedNanos] in all. */
internal class SettableClocks(@Volatile var monotonicNanos: Long, @Volatile var suspendedNanos: Long) {
    val clocks = SystemClocks(boot = { monotonicNanos + suspendedNanos }, monotonic = { monotonicNanos })
    val bootNanos: Long get() = clocks.boot.nowNanos()
}
