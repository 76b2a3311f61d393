package dev.ml2sensors.simulator.signal

import dev.ml2sensors.source.DropReason
import dev.ml2sensors.source.LostSamples
import java.nio.ByteBuffer
import java.nio.ByteOrder
import java.util.Collections
import java.util.IdentityHashMap
import java.util.concurrent.ArrayBlockingQueue
import java.util.concurrent.atomic.AtomicInteger

/**
 * A pool of at most [count] direct buffers of [bufferBytes] each, allocated when first needed.
 *
 * Thread-safe. The memory lives as long as the pool is reachable, so no reader loses it.
 */
internal class BufferPool(val bufferBytes: Int, val count: Int) {
    private val free = ArrayBlockingQueue<ByteBuffer>(count)
    private val allocated = AtomicInteger()
    private val inUse: MutableSet<ByteBuffer> = Collections.synchronizedSet(
        Collections.newSetFromMap(IdentityHashMap()),
    )

    /** The number of buffers in use. */
    internal val outstanding: Int get() = inUse.size

    /**
     * Returns a cleared buffer, or null if all are in use. The caller then delivers [LostSamples] with
     * [DropReason.NO_BUFFER].
     */
    fun acquire(): ByteBuffer? = (free.poll() ?: allocate())?.clear()?.also(inUse::add)

    /** Returns a cleared buffer, and blocks while all are in use; for sources that can wait. */
    fun acquireBlocking(): ByteBuffer = acquire() ?: free.take().clear().also(inUse::add)

    /** Returns a buffer to the pool; the caller must not use it any more. */
    fun release(buffer: ByteBuffer) {
        check(inUse.remove(buffer)) { "the buffer is not in use, or belongs to another pool" }
        free.add(buffer)
    }

    private fun allocate(): ByteBuffer? {
        val number = allocated.getAndUpdate { minOf(it + 1, count) }
        return if (number < count) ByteBuffer.allocateDirect(bufferBytes).order(ByteOrder.LITTLE_ENDIAN) else null
    }
}
