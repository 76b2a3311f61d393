package dev.ml2sensors.capture

import dev.ml2sensors.source.DeviceClock

/** CLOCK_BOOTTIME, read by the library that stamps frames. Thread-safe. */
internal object NativeHeadsetClock : DeviceClock {
    override fun nowNanos(): Long = Native.now()
}
