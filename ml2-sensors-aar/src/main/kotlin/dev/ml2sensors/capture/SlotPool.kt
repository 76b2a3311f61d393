package dev.ml2sensors.capture

import dev.ml2sensors.table.StreamSpec
import java.nio.ByteBuffer
import java.nio.ByteOrder

/**
 * A use of the slots of [stream], of which a process has one set. A slot has the memory of the frames that the stream
 * runs with. After the last use of a stream each slot's memory goes with its last lease. Any thread.
 */
internal class SlotPool(private val stream: StreamSpec) : AutoCloseable {
    init {
        Native.reserve(stream.number)
    }

    override fun close(): Unit = Native.retire(stream.number)

    companion object {
        /** ML2S_MAX_SLOTS: four queued for the network, one on its way, one at the collector, two handed over. */
        const val SLOTS = 8

        /** The bytes [range] of the leased slot [index], from position to limit, little endian. */
        fun bytes(stream: StreamSpec, index: Int, range: IntRange): ByteBuffer =
            Native.bytes(stream.number, index, range.first, range.last + 1 - range.first).order(ByteOrder.LITTLE_ENDIAN)

        /** Ends one lease. */
        fun release(stream: StreamSpec, index: Int): Unit = Native.release(stream.number, index)
    }
}
