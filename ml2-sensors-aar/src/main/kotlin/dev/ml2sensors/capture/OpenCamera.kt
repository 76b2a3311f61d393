package dev.ml2sensors.capture

import dev.ml2sensors.source.DropReason
import dev.ml2sensors.source.ImageSample
import dev.ml2sensors.source.LostSamples
import dev.ml2sensors.source.Sample
import dev.ml2sensors.table.StreamTable

/** The open handle of a [PixelSensor]; of the thread that makes it. */
internal class OpenCamera(
    private val sensor: PixelSensor,
    private val backend: NativeBackend,
    subscriptions: List<Subscription>,
) : OpenSensor {
    private val frames = FrameBlock(sensor.streams.size)
    private val lastNumbers = HashMap<Int, Long>()
    private var settings = prepare(subscriptions)
    private val handle = settings.open()

    override fun configure(subscriptions: List<Subscription>) {
        val next = prepare(subscriptions)
        if (next == settings) return
        next.configure(handle)
        settings = next
        lastNumbers.clear()
    }

    override fun deliver(subscriptions: List<Subscription>) {
        for (index in 0 until Native.poll(handle, POLL_NANOS, frames.memory)) {
            val frame = frames[index]
            if (frame.slot !=
                NativeFrame.NO_SLOT
            ) {
                LocalFrames.publish(StreamTable.all[frame.stream], frames.memory, index)
            }
            val sample = frame.toSample()
            val missed = missedBefore(frame)
            for (subscription in subscriptions) {
                if (subscription.stream.number != frame.stream) continue
                (sample as? ImageSample)?.retain()
                subscription.handOver.lose(missed, DropReason.SOURCE_LATE)
                subscription.handOver.offer(sample)
            }
            (sample as? ImageSample)?.release()
        }
    }

    /** Frames of the same stream that the device captured and nobody fetched in time; its numbers may begin anew. */
    private fun missedBefore(frame: NativeFrame): Int {
        val last = lastNumbers.put(frame.stream, frame.frameNumber) ?: return 0
        return (frame.frameNumber - last - 1).coerceIn(0, Int.MAX_VALUE.toLong()).toInt()
    }

    override fun close(): Unit = Native.close(handle)

    /** Makes room for the frames to come. */
    private fun prepare(subscriptions: List<Subscription>): NativeSettings {
        subscriptions.forEach { SlotPool.of(it.stream) }
        return NativeSettings.of(sensor, backend, subscriptions)
    }

    private companion object {
        /** How late a change of the subscriptions can be noticed. */
        const val POLL_NANOS = 100_000_000L
    }
}

/** In the slot's memory, which the sample gives back; or lost for want of a slot. */
private fun NativeFrame.toSample(): Sample {
    if (slot == NativeFrame.NO_SLOT) return LostSamples(captureNanos, 1, DropReason.NO_BUFFER)
    val slot = slot
    val pool = SlotPool.of(StreamTable.all[stream])
    return ImageSample(
        captureNanos,
        frameNumber,
        width,
        height,
        strideBytes(NativeFrame.IMAGE),
        pose?.toOptical(),
        intrinsics,
        settings,
        PLANE_ROLES.mapIndexedNotNull { plane, role ->
            rangeOf(plane)?.let { ImageSample.Plane(role, pool.bytes(slot, it)) }
        },
        giveBack = { pool.release(slot) },
    )
}

/** The stream table's name of each ml2s_plane_role. */
private val PLANE_ROLES = listOf(ImageSample.IMAGE, "confidence", "flags")
