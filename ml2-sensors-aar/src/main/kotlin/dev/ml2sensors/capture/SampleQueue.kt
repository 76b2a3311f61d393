package dev.ml2sensors.capture

import dev.ml2sensors.source.DropReason
import dev.ml2sensors.source.ImageSample
import dev.ml2sensors.source.LostSamples
import dev.ml2sensors.source.Sample
import kotlinx.coroutines.channels.BufferOverflow
import kotlinx.coroutines.channels.Channel
import kotlinx.coroutines.flow.FlowCollector
import kotlinx.coroutines.selects.select
import java.util.concurrent.atomic.AtomicIntegerArray

/**
 * Between the thread of a sensor, which never waits, and one collector. When [capacity] samples wait, the oldest makes
 * room and is counted as [DropReason.SOURCE_LATE]. Losses are reported before the next sample, without one, and before
 * the end. Images that nobody will take are released.
 */
internal class SampleQueue(capacity: Int) {
    private val lost = AtomicIntegerArray(DropReason.entries.size)
    private val losses = Channel<Unit>(Channel.CONFLATED)
    private val samples = Channel(capacity, BufferOverflow.DROP_OLDEST, ::drop)
    private var lastCaptureNanos = 0L

    /** Takes over one use of an image. Only by the sensor's thread. */
    fun offer(sample: Sample) {
        if (samples.trySend(sample).isFailure) (sample as? ImageSample)?.release()
    }

    /** Counts samples that will not come. Any thread. */
    fun countLost(count: Int, reason: DropReason) {
        if (count == 0) return
        lost.addAndGet(reason.ordinal, count)
        losses.trySend(Unit)
    }

    /** What waits is still delivered; then the collector ends, with [cause] if there is one. Any thread. */
    fun close(cause: Throwable?) {
        samples.close(cause)
    }

    /** Until closed; images are lent until [collector] returns. */
    suspend fun deliverTo(collector: FlowCollector<Sample>) {
        try {
            while (true) {
                val next = select {
                    samples.onReceiveCatching { it }
                    losses.onReceive { null }
                }
                val sample = next?.getOrNull()
                try {
                    sample?.let { lastCaptureNanos = it.captureNanos }
                    reportLosses(collector)
                    sample?.let { collector.emit(it) }
                } finally {
                    (sample as? ImageSample)?.release()
                }
                if (next?.isClosed == true) return next.exceptionOrNull()?.let { throw it } ?: Unit
            }
        } finally {
            samples.cancel()
        }
    }

    private suspend fun reportLosses(collector: FlowCollector<Sample>) {
        for (reason in DropReason.entries) {
            val count = lost.getAndSet(reason.ordinal, 0)
            if (count > 0) collector.emit(LostSamples(lastCaptureNanos, count, reason))
        }
    }

    private fun drop(sample: Sample) {
        (sample as? ImageSample)?.release()
        if (sample is LostSamples) countLost(sample.count, sample.reason) else countLost(1, DropReason.SOURCE_LATE)
    }
}
