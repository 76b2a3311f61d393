package dev.ml2sensors.android

/**
 * Leaves out captures of a camera that is faster than [rateHz]: the settings of another app may win over ours. Begins
 * when [SURE] captures in a row were too fast, and ends with the first pause. Used by one thread.
 */
internal class Thinning(private val rateHz: Int) {
    private val wantedNanos = NANOS_PER_SECOND / rateHz
    private var lastNanos = Long.MIN_VALUE / 2
    private var fast = 0
    private var nextNanos = 0L

    /** Returns true if the capture at [captureNanos] is to be delivered. Called once for each, in order. */
    fun admits(captureNanos: Long): Boolean {
        val periodNanos = captureNanos - lastNanos
        lastNanos = captureNanos
        fast = if (periodNanos in SHORTEST_NANOS..wantedNanos * 4 / 5) fast + 1 else 0
        if (fast < SURE) {
            nextNanos = captureNanos + wantedNanos
            return true
        }
        // Captures do not come at exact times: half of their own period decides
        if (captureNanos < nextNanos - periodNanos / 2) return false
        nextNanos = maxOf(nextNanos + wantedNanos, captureNanos)
        return true
    }

    private companion object {
        const val NANOS_PER_SECOND = 1_000_000_000L

        /** No camera of the headset has more than 250 images per second; what comes faster had waited. */
        const val SHORTEST_NANOS = 4_000_000L
        const val SURE = 8
    }
}
