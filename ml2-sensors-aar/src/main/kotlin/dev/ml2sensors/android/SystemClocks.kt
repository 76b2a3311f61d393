package dev.ml2sensors.android

import android.os.SystemClock
import dev.ml2sensors.source.DeviceClock
import kotlin.math.abs

/** The clocks of Android that sensors may stamp with; [boot] is the device timebase. */
internal class SystemClocks(
    val boot: DeviceClock = DeviceClock(SystemClock::elapsedRealtimeNanos),
    val monotonic: DeviceClock = DeviceClock(System::nanoTime),
) {
    /** Returns how far [boot] is ahead of [monotonic]: how long the device was suspended, to less than a millisecond. */
    fun suspendedNanos(): Long = boot.nowNanos() - monotonic.nowNanos()
}

/**
 * Measures how far [SystemClocks.boot] is ahead of [SystemClocks.monotonic]. The difference changes only when the
 * device was suspended. Keeps the tightest bracket of two readings until a measurement contradicts it. Used by one
 * thread.
 */
internal class MonotonicOffset(private val clocks: SystemClocks) {
    private var offsetNanos = 0L
    private var uncertaintyNanos = Long.MAX_VALUE

    fun nanos(): Long {
        val before = clocks.monotonic.nowNanos()
        val boot = clocks.boot.nowNanos()
        val after = clocks.monotonic.nowNanos()
        val measured = boot - (before + (after - before) / 2)
        val uncertainty = (after - before) / 2 + CLOCK_RESOLUTION_NANOS
        if (uncertainty <= uncertaintyNanos || abs(measured - offsetNanos) > uncertainty + uncertaintyNanos) {
            offsetNanos = measured
            uncertaintyNanos = uncertainty
        }
        return offsetNanos
    }

    private companion object {
        const val CLOCK_RESOLUTION_NANOS = 1L
    }
}
