package dev.ml2sensors.capture

import dev.ml2sensors.table.StreamSpec
import java.nio.ByteBuffer
import java.nio.ByteOrder
import java.util.concurrent.ConcurrentHashMap

/**
 * The memory that the library writes the frames of [stream] into. A process has one per stream, allocated when the
 * stream first runs and kept until the process ends, since the library's slots are the process's too: nobody who
 * still reads a frame can lose it. Any thread.
 */
internal class SlotPool private constructor(private val stream: StreamSpec) {
    private val slots: List<ByteBuffer>

    init {
        val slotBytes = (stream.largestFrameBytes() + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT
        val memory = ByteBuffer.allocateDirect(COUNT * slotBytes + ALIGNMENT)
        memory.position((ALIGNMENT - Native.addressOf(memory) % ALIGNMENT).toInt())
        val aligned = memory.slice()
        slots = List(COUNT) { aligned.part(it * slotBytes, slotBytes) }
        Native.provide(stream.number, aligned, slotBytes, COUNT)
    }

    /** The bytes [range] of slot [index], from position to limit, little endian. */
    fun bytes(index: Int, range: IntRange): ByteBuffer = slots[index].part(range.first, range.last + 1 - range.first)

    /** Ends one lease. */
    fun release(index: Int): Unit = Native.release(stream.number, index)

    companion object {
        /** ML2S_MAX_SLOTS: four queued for the network, one on its way, one at the collector, two handed over. */
        private const val COUNT = 8
        private const val ALIGNMENT = 64

        private val pools = ConcurrentHashMap<StreamSpec, SlotPool>()

        fun of(stream: StreamSpec): SlotPool = pools.computeIfAbsent(stream, ::SlotPool)
    }
}

private fun ByteBuffer.part(offset: Int, bytes: Int): ByteBuffer {
    val part = duplicate()
    part.position(offset).limit(offset + bytes)
    return part.slice().order(ByteOrder.LITTLE_ENDIAN)
}

/**
 * Room for a frame of the stream's largest mode, with all planes. A JPEG, whose buffer the runtime chooses the size of,
 * has that of the picture in YUV 4:2:0. What is no camera has [LatestReadings].
 */
private fun StreamSpec.largestFrameBytes(): Int {
    if (modes.isEmpty()) return LatestReadings.FRAME_BYTES
    val pixels = modes.maxOf { mode -> mode.resolutions.maxOf { (width, height) -> width * height } }
    val images = topics.filter { it.type == "sensor_msgs/msg/Image" }
    return if (images.isEmpty()) pixels * 3 / 2 else images.sumOf { pixels * bytesPerPixel(it.encoding ?: encoding) }
}

private fun bytesPerPixel(encoding: String?): Int = when (encoding) {
    "mono8" -> 1
    "32FC1", "32SC1" -> 4
    else -> error("pixels of encoding $encoding have no known size")
}
