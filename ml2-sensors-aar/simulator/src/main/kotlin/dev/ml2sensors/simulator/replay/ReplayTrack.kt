package dev.ml2sensors.simulator.replay

import dev.ml2sensors.source.Sample
import java.util.concurrent.atomic.AtomicInteger

/** The recorded times of one stream, and a function that makes the sample of a row. */
internal class ReplayTrack(val stamps: LongArray, val sample: suspend (row: Int, captureNanos: Long) -> Sample) {
    private val resumeRow = AtomicInteger(0)

    /** The row at which a new collection starts: the furthest row at which one has ended. */
    val nextRow: Int get() = resumeRow.get()

    fun resumeAt(row: Int) {
        resumeRow.accumulateAndGet(row, ::maxOf)
    }
}
