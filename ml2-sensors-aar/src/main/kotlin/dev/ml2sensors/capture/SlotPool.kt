package dev.ml2sensors.capture

import dev.ml2sensors.table.StreamSpec
import java.nio.ByteBuffer
import java.nio.ByteOrder

/**
 * One use of the slots of [stream]; a process has two sets for each stream, one of which is for what the library encodes
 * ([isEncoded]). The size of a slot is that of the frames
 * that the stream runs with. After the last use of a stream, the memory of each slot is freed with its last lease.
 * Thread-safe.
 */
internal class SlotPool(private val stream: StreamSpec, isEncoded: Boolean = false) : AutoCloseable {
    /** The number of this set of slots. */
    val set: Int = if (isEncoded) stream.number or ENCODED else stream.number

    init {
        Native.reserve(set)
    }

    /** Leases a free slot for a frame of [sizeBytes] at most; returns null if all are leased, or memory is short. */
    fun take(sizeBytes: Int): Slot? {
        val index = Native.take(set, sizeBytes)
        if (index == NativeFrame.NO_SLOT) return null
        return Slot(stream, index, Native.bytes(set, index, 0, sizeBytes).order(ByteOrder.LITTLE_ENDIAN)) {
            Native.release(set, index)
        }
    }

    override fun close(): Unit = Native.retire(set)

    companion object {
        /**
         * ML2S_MAX_SLOTS: four are queued for the network, one is being sent, one is at the collector, two wait in its
         * queue.
         */
        const val SLOTS = 8

        /** ML2S_ENCODED */
        const val ENCODED = 64

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
internal class Slot(
    val stream: StreamSpec,
    val index: Int,
    val bytes: ByteBuffer,
    private val endLease: () -> Unit,
) {
    /** Ends the lease. Called once, by any thread. */
    fun release(): Unit = endLease()
}
