package dev.ml2sensors.capture

import dev.ml2sensors.message.MlPose
import dev.ml2sensors.source.HeadPose
import dev.ml2sensors.source.HeadTrack
import dev.ml2sensors.source.ImageSample
import dev.ml2sensors.source.PoseSample
import dev.ml2sensors.source.VectorSample
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable
import java.nio.ByteBuffer

/**
 * Publishes frames for native readers in the same process, such as a game engine, which lease the latest one with
 * `ml2s_acquire_latest` of native/sdk/ml2s.h. Images are published in their slots; readings are copied into slots. A reader that holds its leases misses new frames, but does not block the sensor. Thread-safe.
 */
internal object LocalFrames {
    private class View {
        var isOn = false

        /** The slots for readings. */
        var slots: SlotPool? = null
        val frames by lazy { FrameBlock(1) }
        val readings by lazy { LatestReadings() }
    }

    private val head = HeadTrack()
    private val views = StreamTable.all.associateWith { View() }

    /**
     * Enables or disables publishing of [stream]; it does not start or stop the stream. While it is disabled, no frame
     * is published or copied, and none is the latest.
     */
    fun view(stream: StreamSpec, isOn: Boolean) {
        check(NativeLibrary.isLoaded) { "frames are read from libml2sensors.so, which is not loaded" }
        val view = views.getValue(stream)
        synchronized(view) {
            view.isOn = isOn
            if (!isOn) {
                view.slots?.close()
                view.slots = null
                Native.unpublish(stream.number)
            }
        }
    }

    /** Adds a pose of the head; frames are published with the head's pose at their capture. */
    internal fun addHead(sample: PoseSample): Unit = synchronized(head) { head.add(sample) }

    /** Forgets the head's poses: the next one is not connected to them. */
    internal fun clearHead(): Unit = synchronized(head) { head.clear() }

    /** Publishes number [index] of polled [frames], in its slot. */
    internal fun publish(stream: StreamSpec, frames: FrameBlock, index: Int): Unit = ifViewed(stream) {
        val frame = frames[index]
        frame.headPose = headPoseAt(frame.captureNanos)
        Native.publish(frames.memory, index)
    }

    private fun headPoseAt(captureNanos: Long): MlPose? =
        (synchronized(head) { head.at(captureNanos) } as? HeadPose.Tracked)?.pose?.let(MlPose::ofBody)

    /** Publishes [sample], whose pixels are the first bytes of [slot]. Called once for a lease. */
    internal fun publish(slot: Slot, sample: ImageSample): Unit = ifViewed(slot.stream) { view ->
        publish(slot, sample.pixels.remaining(), view) { fill(sample) }
    }

    /**
     * Adds [sample] to the latest readings of a vector sensor, which are published as one frame: see [LatestReadings].
     */
    internal fun copy(stream: StreamSpec, sample: VectorSample): Unit = ifViewed(stream) { view ->
        val slots = view.slots ?: SlotPool(stream).also { view.slots = it }
        val readings = view.readings.add(sample)
        val sizeBytes = readings.remaining()
        val slot = slots.take(roomFor(sizeBytes)) ?: return@ifViewed
        try {
            slot.bytes.put(readings)
            publish(slot, sizeBytes, view) { fill(sample) }
        } finally {
            slot.release()
        }
    }

    private inline fun publish(slot: Slot, sizeBytes: Int, view: View, describe: NativeFrame.() -> Unit) {
        val frame = view.frames[0]
        frame.place(slot.stream.number, slot.index, sizeBytes)
        frame.describe()
        frame.headPose = headPoseAt(frame.captureNanos)
        Native.publish(view.frames.memory, 0)
    }

    /** Rounds up to a power of two, so that slots keep their memory while the number of readings grows. */
    private fun roomFor(sizeBytes: Int) = Integer.highestOneBit(sizeBytes - 1).coerceAtLeast(LEAST_BYTES) * 2

    private const val LEAST_BYTES = 1 shl 11

    private inline fun ifViewed(stream: StreamSpec, action: (View) -> Unit) {
        val view = views.getValue(stream)
        synchronized(view) { if (view.isOn) action(view) }
    }
}
