package dev.ml2sensors.simulator.simulated

import dev.ml2sensors.source.DeviceClock

/**
 * Holds back the samples of all sensors while camera frames are being rendered, so that all sensors start together and
 * none is late. Opens once nothing has been rendered for [QUIET_NANOS], and then stays open. Thread-safe.
 */
internal class RenderGate(private val clock: DeviceClock, private val isDrawing: () -> Boolean) {
    @Volatile
    private var isOpen = false
    private var quietSinceNanos: Long? = null

    /** True while samples are being held back. */
    val isClosed: Boolean @Synchronized get() = quietSinceNanos != null && !isOpen

    /** Returns true if a sample may pass. Call it for each sample. */
    fun isOpen(): Boolean = isOpen || update()

    @Synchronized
    private fun update(): Boolean {
        val now = clock.nowNanos()
        val since = quietSinceNanos?.takeUnless { isDrawing() } ?: now
        quietSinceNanos = since
        isOpen = now - since > QUIET_NANOS
        return isOpen
    }

    private companion object {
        /** Longer than it takes to start all streams of a configuration, and than the gap between two cameras. */
        const val QUIET_NANOS = 200_000_000L
    }
}
