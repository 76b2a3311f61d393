package dev.ml2sensors.capture

import dev.ml2sensors.source.DropReason
import dev.ml2sensors.source.ImageSample
import dev.ml2sensors.source.Sample
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable

/** The open handle of a [PixelSensor]; used by the thread that makes it. */
internal class OpenCamera(
    private val sensor: PixelSensor,
    private val backend: NativeBackend,
    subscriptions: List<Subscription>,
) : OpenSensor {
    private val frames = FrameBlock(sensor.streams.size)
    private val lastNumbers = HashMap<Int, Long>()
    private val slots = HashMap<StreamSpec, SlotPool>()
    private var settings = NativeSettings.of(sensor, backend, subscriptions)
    private val handle = withSlots(subscriptions) { settings.open() }

    override fun configure(subscriptions: List<Subscription>) {
        val next = NativeSettings.of(sensor, backend, subscriptions)
        if (next == settings) return
        withSlots(subscriptions) { next.configure(handle) }
        settings = next
        lastNumbers.keys.retainAll(subscriptions.map { it.stream.number }.toSet())
    }

    override fun deliver(subscriptions: List<Subscription>) {
        val count = Native.poll(handle, POLL_NANOS, frames.memory)
        frames.deliver(count) { index, frame, sample ->
            val stream = StreamTable.all[frame.stream]
            if (sample is ImageSample) LocalFrames.publish(stream, frames, index)
            queue(sample, frame, subscriptions.filter { it.stream == stream })
        }
    }

    private fun queue(sample: Sample, frame: NativeFrame, subscriptions: List<Subscription>) {
        val missed = missedBefore(frame)
        for (subscription in subscriptions) {
            (sample as? ImageSample)?.retain()
            subscription.queue.countLost(missed, DropReason.SOURCE_LATE)
            if (frame.isUsable) subscription.queue.countLost(frame.skipped, DropReason.UNUSABLE)
            subscription.queue.offer(sample)
        }
    }

    /**
     * Returns how many frames of the stream the device captured and nobody fetched in time; its numbers may restart.
     */
    private fun missedBefore(frame: NativeFrame): Int {
        val last = lastNumbers[frame.stream]
        if (!frame.isUsable) {
            // It has no number, but the device counted it
            if (last != null) lastNumbers[frame.stream] = last + 1
            return 0
        }
        lastNumbers[frame.stream] = frame.frameNumber
        return if (last == null) 0 else (frame.frameNumber - last - 1).coerceIn(0, Int.MAX_VALUE.toLong()).toInt()
    }

    override fun close() {
        try {
            Native.close(handle)
        } finally {
            slots.values.forEach(SlotPool::close)
        }
    }

    /**
     * Runs [action] with slots for the streams of [subscriptions], and releases other slots afterwards; restores the
     * previous slots if it fails.
     */
    private inline fun <T> withSlots(subscriptions: List<Subscription>, action: () -> T): T {
        val streams = subscriptions.map { it.stream }.toSet()
        val before = slots.keys.toSet()
        try {
            (streams - before).forEach { slots[it] = SlotPool(it) }
            return action().also { releaseSlots(before - streams) }
        } catch (e: Throwable) {
            releaseSlots(slots.keys - before)
            throw e
        }
    }

    private fun releaseSlots(streams: Set<StreamSpec>) = streams.forEach { slots.remove(it)?.close() }

    private companion object {
        /** The longest delay until a change of the subscriptions takes effect. */
        const val POLL_NANOS = 100_000_000L
    }
}
