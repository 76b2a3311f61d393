package dev.ml2sensors.simulator.simulated

import dev.ml2sensors.source.DeviceClock

/**
 * Holds all sensors back while what the cameras will show is being drawn, so that they begin together and none is late
 * because of it. Over once nothing has been drawn for [QUIET_NANOS]; then for good. Any thread.
 */
internal class Opening(private val clock: DeviceClock, private val isDrawing: () -> Boolean) {
    @Volatile
    private var isOver = false
    private var quietSinceNanos: Long? = null

    /** Whether samples are being held back. */
    val isHolding: Boolean @Synchronized get() = quietSinceNanos != null && !isOver

    /** To be asked at each sample. */
    fun isOver(): Boolean = isOver || look()

    @Synchronized
    private fun look(): Boolean {
        val now = clock.nowNanos()
        val since = quietSinceNanos?.takeUnless { isDrawing() } ?: now
        quietSinceNanos = since
        isOver = now - since > QUIET_NANOS
        return isOver
    }

    private companion object {
        /** In which all streams of a configuration are started, and one camera follows another. */
        const val QUIET_NANOS = 200_000_000L
    }
}
