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
 * `ml2s_acquire_latest` of native/sdk/ml2s.h. Frames of the library's own sensors are already in its slots; others are
 * copied into slots. A reader that holds its leases misses new frames, but does not block the sensor. Thread-safe.
 */
internal object LocalFrames {
    private class View {
        var isOn = false

        /** The slots for copied frames. */
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

    /** Copies and publishes [sample], unless all slots are leased. */
    internal fun copy(stream: StreamSpec, sample: ImageSample): Unit = ifViewed(stream) { view ->
        copy(stream, view, sample.pixels) { fill(sample) }
    }

    /**
     * Adds [sample] to the latest readings of a vector sensor, which are published as one frame: see [LatestReadings].
     */
    internal fun copy(stream: StreamSpec, sample: VectorSample): Unit = ifViewed(stream) { view ->
        copy(stream, view, view.readings.add(sample)) { fill(sample) }
    }

    private inline fun copy(
        stream: StreamSpec,
        view: View,
        bytes: ByteBuffer,
        describe: NativeFrame.() -> Unit,
    ) {
        if (view.slots == null) view.slots = SlotPool(stream)
        val sizeBytes = bytes.remaining()
        val slot = Native.take(stream.number, roomFor(sizeBytes))
        if (slot == NativeFrame.NO_SLOT) return
        try {
            SlotPool.bytes(stream, slot, 0 until sizeBytes).put(bytes)
            view.frames[0].place(stream.number, slot, sizeBytes)
            view.frames[0].describe()
            view.frames[0].headPose = headPoseAt(view.frames[0].captureNanos)
            Native.publish(view.frames.memory, 0)
        } finally {
            SlotPool.release(stream, slot)
        }
    }

    /** Rounds up to a power of two, so that slots keep their memory although the size of JPEGs varies. */
    private fun roomFor(sizeBytes: Int) = Integer.highestOneBit(sizeBytes - 1).coerceAtLeast(LEAST_BYTES) * 2

    private const val LEAST_BYTES = 1 shl 11

    private inline fun ifViewed(stream: StreamSpec, action: (View) -> Unit) {
        val view = views.getValue(stream)
        synchronized(view) { if (view.isOn) action(view) }
    }
}
