package dev.ml2sensors.pacing

/**
 * A round trip of the time lane while images are sent. The kernel of the receiver acknowledges images at once, but its
 * program, which answers, may be busy. So the path of a round trip took no longer than the acknowledgement of all images
 * that were sent before it.
 *
 * @property startNanos when it began.
 * @param writtenBytes the bytes of all images that were sent by then.
 * @param acknowledgedBytes how many of them were acknowledged by then; null if that is not known.
 */
internal class RoundTrip(val startNanos: Long, private val writtenBytes: Long, acknowledgedBytes: Long?) {
    private var acknowledgedNanos: Long? = null

    /** False if no image was before it on the path. Then it does not tell how long images wait there. */
    private val followsImages = acknowledgedBytes == null || writtenBytes - acknowledgedBytes > UNSURE_BYTES

    /** True as long as images that were sent before it may be on the path. */
    val isBehindImages: Boolean get() = followsImages && acknowledgedNanos == null

    /** By [nowNanos], [bytes] of images were acknowledged since the session began. */
    fun acknowledged(bytes: Long, nowNanos: Long) {
        if (acknowledgedNanos == null && bytes >= writtenBytes - UNSURE_BYTES) acknowledgedNanos = nowNanos
    }

    /** Returns how long it took on the path, in ns, if it ended at [nowNanos]; null if no images were before it. */
    fun onPathNanos(nowNanos: Long): Long? =
        if (followsImages) (acknowledgedNanos ?: nowNanos) - startNanos else null

    private companion object {
        /** Two segments, which TCP may acknowledge 40 ms later (RFC 9293, 3.8.6.3). */
        const val UNSURE_BYTES = 2 * 1460
    }
}
