package dev.ml2sensors.simulator.replay

import dev.ml2sensors.source.Sample
import java.util.concurrent.atomic.AtomicInteger

/**
 * Maps recorded times to capture times and due times, for a replay that started at [startNanos].
 *
 * @param firstRecordedNanos the first time in the recording, over all sensors.
 * @param rateFactor how many times as fast as recorded; if infinite, all samples are due at once.
 */
internal class ReplaySchedule(startNanos: Long, private val firstRecordedNanos: Long, private val rateFactor: Double) {
    private val firstDueNanos = startNanos + LEAD_NANOS
    private val offsetNanos = firstDueNanos - firstRecordedNanos

    /** Returns the capture time on the device clock. Differences are those of the recording, whatever the rate. */
    fun captureNanos(recordedNanos: Long): Long = recordedNanos + offsetNanos

    fun dueNanos(recordedNanos: Long): Long =
        firstDueNanos + ((recordedNanos - firstRecordedNanos) / rateFactor).toLong()

    companion object {
        /** Leaves time for every stream to be collected before its first sample is due. */
        const val LEAD_NANOS: Long = 200_000_000
    }
}

/** The recorded times of one stream, and a function that makes the sample of a row. */
internal class ReplayTrack(val stamps: LongArray, val sample: suspend (row: Int, captureNanos: Long) -> Sample) {
    private val resumeRow = AtomicInteger(0)

    /** The row at which a new collection starts: the furthest row at which one has ended. */
    val nextRow: Int get() = resumeRow.get()

    fun resumeAt(row: Int) {
        resumeRow.accumulateAndGet(row, ::maxOf)
    }
}
