package dev.ml2sensors.capture

import dev.ml2sensors.source.VectorSample
import java.nio.ByteBuffer
import java.nio.ByteOrder

/**
 * Keeps the latest [MOST] readings of a vector sensor as one frame, oldest first, so that a reader that looks once per
 * picture misses none. Each reading is an i64 capture time in ns of CLOCK_BOOTTIME, then f64 x, y, z.
 */
internal class LatestReadings {
    private val memory = ByteBuffer.allocate(FRAME_BYTES).order(ByteOrder.LITTLE_ENDIAN)

    /** Adds [sample] and returns all readings from position to limit; valid until the next call. */
    fun add(sample: VectorSample): ByteBuffer {
        if (!memory.hasRemaining()) {
            memory.position(READING_BYTES)
            memory.compact()
        }
        memory.putLong(sample.captureNanos).putDouble(sample.x).putDouble(sample.y).putDouble(sample.z)
        return memory.duplicate().flip() as ByteBuffer
    }

    companion object {
        /** One third of a second at 200 Hz. */
        const val MOST = 64
        private const val READING_BYTES = Long.SIZE_BYTES + 3 * Double.SIZE_BYTES
        const val FRAME_BYTES = MOST * READING_BYTES
    }
}
