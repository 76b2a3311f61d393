package dev.ml2sensors.transport

import java.nio.ByteBuffer

/** Direct buffers that outlive connections, since only a garbage collection frees one. */
internal object DirectBufferPool {
    /** Three TLS records of the largest size, and a fourth of most. */
    const val BUFFER_BYTES: Int = 64 * 1024

    private val free = ArrayDeque<ByteBuffer>()

    /** Empty, to be given back by who no longer uses it. */
    @Synchronized
    fun acquire(): ByteBuffer = free.removeLastOrNull()?.also { it.clear() } ?: ByteBuffer.allocateDirect(BUFFER_BYTES)

    @Synchronized
    fun release(buffer: ByteBuffer): Unit = free.addLast(buffer)
}
