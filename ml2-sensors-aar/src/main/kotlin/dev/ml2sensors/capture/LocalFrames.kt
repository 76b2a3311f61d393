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
 * Frames for readers of the same process beside Kotlin, such as a game engine, which lease the latest one by
 * `ml2s_acquire_latest` of native/sdk/ml2s.h. Frames of the library's own sensors are in its slots already; others are
 * copied into them. A reader that keeps its leases costs itself new frames, not the sensor. Any thread.
 */
internal object LocalFrames {
    private class View {
        var isOn = false

        /** For frames that are copied. */
        var slots: SlotPool? = null
        val frames by lazy { FrameBlock(1) }
        val readings by lazy { LatestReadings() }
    }

    private val head = HeadTrack()
    private val views = StreamTable.all.associateWith { View() }

    /**
     * Whether running streams publish their frames; the stream itself is run by others. Nothing is published and nothing
     * is copied for a [stream] that is not viewed, and no frame of it is the latest any more.
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

    /** Adds the head's pose, which frames of its time are published with. */
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

    /** Copies [sample], of a sensor that is not the library's; unless all slots are leased. */
    internal fun copy(stream: StreamSpec, sample: ImageSample): Unit = ifViewed(stream) { view ->
        copy(stream, view, sample.pixels) { fill(sample) }
    }

    /** Adds [sample] to the latest readings of a vector sensor, which are one frame together: see [LatestReadings]. */
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

    /** The next power of two, so that slots keep their memory though no JPEG has the size of the one before. */
    private fun roomFor(sizeBytes: Int) = Integer.highestOneBit(sizeBytes - 1).coerceAtLeast(LEAST_BYTES) * 2

    private const val LEAST_BYTES = 1 shl 11

    private inline fun ifViewed(stream: StreamSpec, action: (View) -> Unit) {
        val view = views.getValue(stream)
        synchronized(view) { if (view.isOn) action(view) }
    }
}
