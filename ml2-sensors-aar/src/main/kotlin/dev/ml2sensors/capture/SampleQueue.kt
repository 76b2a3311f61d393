package dev.ml2sensors.capture

import dev.ml2sensors.source.DropReason
import dev.ml2sensors.source.ImageSample
import dev.ml2sensors.source.LostSamples
import dev.ml2sensors.source.PoseSample
import dev.ml2sensors.source.Sample
import kotlinx.coroutines.CancellationException
import kotlinx.coroutines.channels.BufferOverflow
import kotlinx.coroutines.channels.Channel
import kotlinx.coroutines.flow.FlowCollector
import kotlinx.coroutines.selects.select
import java.util.concurrent.atomic.AtomicIntegerArray
import java.util.concurrent.atomic.AtomicLong

/**
 * The queue between a sensor's thread, which never waits, and one collector. When [capacity] samples wait, the oldest
 * is dropped and counted as [DropReason.SOURCE_LATE]. Losses are reported before the next sample and before the end. If
 * a dropped pose was the first in a new world, the next delivered pose says so. Images that are not collected are
 * released.
 */
internal class SampleQueue(capacity: Int) {
    private val lost = AtomicIntegerArray(DropReason.entries.size)
    private val losses = Channel<Unit>(Channel.CONFLATED)
    private val samples = Channel(capacity, BufferOverflow.DROP_OLDEST, ::drop)
    private var lastCaptureNanos = 0L

    /** The capture time of a dropped pose that was the first in a new world; [NONE] if no later pose has to say so. */
    private val newWorldNanos = AtomicLong(NONE)

    /** Adds a sample and takes over one reference of an image. Called by the sensor's thread only. */
    fun offer(sample: Sample) {
        if (samples.trySend(sample).isFailure) (sample as? ImageSample)?.release()
    }

    /** Counts samples that will not be delivered. Thread-safe. */
    fun countLost(count: Int, reason: DropReason) {
        if (count == 0) return
        lost.addAndGet(reason.ordinal, count)
        losses.trySend(Unit)
    }

    /**
     * Ends the queue: waiting samples are still delivered, then the collector ends, with [cause] if there is one.
     * Thread-safe.
     */
    fun close(cause: Throwable?) {
        samples.close(cause)
    }

    /** Runs [produce], and ends the queue with its failure if it has one. A cancellation does not end the queue. */
    inline fun closeAfter(produce: () -> Unit) {
        val failure = try {
            produce()
            null
        } catch (e: CancellationException) {
            throw e
        } catch (e: Exception) {
            e
        }
        close(failure)
    }

    /** Passes samples to [collector] until the queue is closed. An image is valid until [collector] returns. */
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
                    sample?.let { collector.emit(inItsWorld(it)) }
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

    /** Poses before the dropped one may still be delivered after it was dropped; they are in the old world. */
    private fun inItsWorld(sample: Sample): Sample {
        val since = newWorldNanos.get()
        if (since == NONE || sample !is PoseSample || sample.captureNanos < since) return sample
        newWorldNanos.compareAndSet(since, NONE)
        return PoseSample(sample.captureNanos, sample.pose, isInNewWorld = true, sample.condition)
    }

    private fun drop(sample: Sample) {
        if (sample is PoseSample && sample.isInNewWorld) newWorldNanos.set(sample.captureNanos)
        (sample as? ImageSample)?.release()
        if (sample is LostSamples) countLost(sample.count, sample.reason) else countLost(1, DropReason.SOURCE_LATE)
    }

    private companion object {
        const val NONE = Long.MIN_VALUE
    }
}
