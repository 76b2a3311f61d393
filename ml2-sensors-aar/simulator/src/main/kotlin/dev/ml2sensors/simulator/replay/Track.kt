package dev.ml2sensors.simulator.replay

import dev.ml2sensors.source.Sample
import java.util.concurrent.atomic.AtomicInteger

/** What one stream plays: recorded times, and the sample of the row with the same index. */
internal class Track(val stamps: LongArray, val sample: suspend (row: Int, captureNanos: Long) -> Sample) {
    private val leftAt = AtomicInteger(0)

    /** The row a new collection begins with: the furthest at which one has ended. */
    val nextRow: Int get() = leftAt.get()

    fun leave(row: Int) {
        leftAt.accumulateAndGet(row, ::maxOf)
    }
}
