package dev.ml2sensors.capture

import dev.ml2sensors.source.DeviceClock

/** CLOCK_BOOTTIME, read where the stamps of frames are made. Any thread. */
public object NativeHeadsetClock : DeviceClock {
    override fun nowNanos(): Long = Native.now()
}
