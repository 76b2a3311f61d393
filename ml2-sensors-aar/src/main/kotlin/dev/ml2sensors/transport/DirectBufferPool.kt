package dev.ml2sensors.transport

import java.nio.ByteBuffer

/** A pool of direct buffers that outlive connections, since only garbage collection frees one. */
internal object DirectBufferPool {
    /** Three TLS records of the largest size, and most of a fourth. */
    const val BUFFER_BYTES: Int = 64 * 1024

    private val free = ArrayDeque<ByteBuffer>()

    /** Returns a cleared buffer; the caller releases it. */
    @Synchronized
    fun acquire(): ByteBuffer = free.removeLastOrNull()?.also { it.clear() } ?: ByteBuffer.allocateDirect(BUFFER_BYTES)

    @Synchronized
    fun release(buffer: ByteBuffer): Unit = free.addLast(buffer)
}
