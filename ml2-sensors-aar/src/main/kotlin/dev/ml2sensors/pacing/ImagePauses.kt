package dev.ml2sensors.pacing

/** Finds pauses between images. Without a pause, the link delivers as much as it can. Not thread-safe. */
internal class ImagePauses(startNanos: Long) {
    private var busySinceNanos = startNanos
    private var pausedNanos: Long? = startNanos

    /** From now on an image is written, or waits to be. */
    fun end(nowNanos: Long) {
        val pausedNanos = pausedNanos ?: return
        if (nowNanos - pausedNanos > SHORTEST_NANOS) busySinceNanos = nowNanos
        this.pausedNanos = null
    }

    /** No image is left to write. */
    fun begin(nowNanos: Long) {
        pausedNanos = nowNanos
    }

    /** True if images have had no pause for a while. */
    fun areOver(nowNanos: Long): Boolean = pausedNanos == null && nowNanos - busySinceNanos > FILLED_NANOS

    private companion object {
        const val SHORTEST_NANOS = 5_000_000L
        const val FILLED_NANOS = 100_000_000L
    }
}
