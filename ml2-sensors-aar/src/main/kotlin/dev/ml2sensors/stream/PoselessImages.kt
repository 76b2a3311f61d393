package dev.ml2sensors.stream

import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.wire.Event

/**
 * Counts images of [spec] without a pose, and reports their number as an event: when it is [FIRST], whenever it has
 * doubled since, and at the end. Used by one thread at a time.
 */
internal class PoselessImages(private val spec: StreamSpec, private val report: (Event) -> Unit) {
    private var count = 0L
    private var reported = 0L

    fun add(hasPose: Boolean) {
        if (hasPose) return
        count++
        if (count >= maxOf(FIRST, 2 * reported)) reportCount()
    }

    /** Reports the number if it has grown since the last report. */
    fun end() {
        if (count > reported) reportCount()
    }

    private fun reportCount() {
        reported = count
        report(Event(Event.IMAGES_WITHOUT_POSE, "$count images of $spec had no pose since the stream began"))
    }

    private companion object {
        /** A second of images. The first images of a stream may come before the tracker is ready. */
        const val FIRST = 30L
    }
}
