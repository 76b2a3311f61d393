package dev.ml2sensors.link

import java.nio.ByteBuffer

/** Direct buffers that outlive connections, since only a garbage collection frees one. */
internal object BufferStock {
    /** Three TLS records of the largest size, and a fourth of most. */
    const val BUFFER_BYTES: Int = 64 * 1024

    private val free = ArrayDeque<ByteBuffer>()

    /** Empty, to be given back by who no longer uses it. */
    @Synchronized
    fun take(): ByteBuffer = free.removeLastOrNull()?.also { it.clear() } ?: ByteBuffer.allocateDirect(BUFFER_BYTES)

    @Synchronized
    fun giveBack(buffer: ByteBuffer): Unit = free.addLast(buffer)
}
