package dev.ml2sensors.capture

import dev.ml2sensors.source.DeviceClock

/** CLOCK_BOOTTIME, read where the stamps of frames are made. Any thread. */
public object NativeHeadsetClock : DeviceClock {
    override fun nowNanos(): Long = Native.now()

    /** The instant on this clock of an MLTime, such as the vendor's tags of Camera2 carry. */
    public fun ofMlTime(mlTimeNanos: Long): Long = Native.boottimeOf(mlTimeNanos)
}
