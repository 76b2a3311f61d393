package dev.ml2sensors.capture

import dev.ml2sensors.table.StreamSpec
import java.nio.ByteBuffer
import java.nio.ByteOrder

/**
 * One use of the slots of [stream]; a process has one set for each stream. The size of a slot is that of the frames
 * that the stream runs with. After the last use of a stream, the memory of each slot is freed with its last lease.
 * Thread-safe.
 */
internal class SlotPool(private val stream: StreamSpec) : AutoCloseable {
    init {
        Native.reserve(stream.number)
    }

    /** Leases a free slot for a frame of [sizeBytes] at most; returns null if all are leased, or memory is short. */
    fun take(sizeBytes: Int): Slot? {
        val index = Native.take(stream.number, sizeBytes)
        return if (index == NativeFrame.NO_SLOT) null else Slot(stream, index, bytes(stream, index, 0 until sizeBytes))
    }

    override fun close(): Unit = Native.retire(stream.number)

    companion object {
        /**
         * ML2S_MAX_SLOTS: four are queued for the network, one is being sent, one is at the collector, two wait in its
         * queue.
         */
        const val SLOTS = 8

        /** Returns the bytes [range] of the leased slot [index], from position to limit, little endian. */
        fun bytes(stream: StreamSpec, index: Int, range: IntRange): ByteBuffer =
            Native.bytes(stream.number, index, range.first, range.last + 1 - range.first).order(ByteOrder.LITTLE_ENDIAN)

        /** Ends one lease. */
        fun release(stream: StreamSpec, index: Int): Unit = Native.release(stream.number, index)
    }
}

/**
 * A leased slot of [stream] that the caller fills.
 *
 * @property bytes its memory, which must not be used after [release].
 */
internal class Slot(val stream: StreamSpec, val index: Int, val bytes: ByteBuffer) {
    /** Ends the lease. Called once, by any thread. */
    fun release(): Unit = SlotPool.release(stream, index)
}
