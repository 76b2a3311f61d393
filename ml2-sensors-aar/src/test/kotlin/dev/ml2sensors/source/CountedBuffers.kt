package dev.ml2sensors.source

import java.nio.ByteBuffer
import java.nio.ByteOrder
import java.util.Collections
import java.util.IdentityHashMap

/** Direct buffers of [bufferBytes] each, which must all come back, once. Thread-safe. */
internal class CountedBuffers(private val bufferBytes: Int) {
    private val inUse: MutableSet<ByteBuffer> =
        Collections.synchronizedSet(Collections.newSetFromMap(IdentityHashMap()))

    val outstanding: Int get() = inUse.size

    fun acquire(): ByteBuffer =
        ByteBuffer.allocateDirect(bufferBytes).order(ByteOrder.LITTLE_ENDIAN).also(inUse::add)

    fun release(buffer: ByteBuffer): Unit = check(inUse.remove(buffer)) { "the buffer is not in use" }
}
