package dev.ml2sensors.pacing

/** Knows when images were written, waited, and had pauses. Not thread-safe. */
internal class ImageActivity(startNanos: Long) {
    private var busySinceNanos = startNanos
    private var pausedNanos: Long? = startNanos
    private var writtenNanos = startNanos - RECENT_NANOS
    private var waitedNanos = startNanos - WAITING_NANOS

    /** From now on an image is written, or waits to be. */
    fun resume(nowNanos: Long) {
        val pausedNanos = pausedNanos ?: return
        if (nowNanos - pausedNanos > SHORTEST_PAUSE_NANOS) busySinceNanos = nowNanos
        this.pausedNanos = null
    }

    /** No image is left to write. */
    fun pause(nowNanos: Long) {
        pausedNanos = nowNanos
    }

    /** A part of an image was handed to the kernel. */
    fun written(nowNanos: Long) {
        writtenNanos = nowNanos
    }

    /** Images wait at present because of the rate. */
    fun waited(nowNanos: Long) {
        waitedNanos = nowNanos
    }

    fun areWritten(nowNanos: Long): Boolean = nowNanos - writtenNanos < RECENT_NANOS

    fun areWaiting(nowNanos: Long): Boolean = nowNanos - waitedNanos < WAITING_NANOS

    /** True if images have had no pause for a while: then the link delivers as much as it can. */
    fun fillLink(nowNanos: Long): Boolean = pausedNanos == null && nowNanos - busySinceNanos > FILLED_NANOS

    private companion object {
        const val RECENT_NANOS = 200_000_000L
        const val WAITING_NANOS = 50_000_000L
        const val SHORTEST_PAUSE_NANOS = 5_000_000L
        const val FILLED_NANOS = 100_000_000L
    }
}
