package dev.ml2sensors.source

import java.nio.ByteBuffer
import java.nio.ByteOrder
import java.util.Collections
import java.util.IdentityHashMap
import java.util.concurrent.ArrayBlockingQueue
import java.util.concurrent.atomic.AtomicInteger

/**
 * At most [count] direct buffers of [bufferBytes] each, allocated when they are first needed.
 *
 * Any thread may acquire and give back. The memory lives as long as the pool is reachable: it is never unmapped
 * under a reader.
 */
public class BufferPool(public val bufferBytes: Int, public val count: Int) {
    private val free = ArrayBlockingQueue<ByteBuffer>(count)
    private val allocated = AtomicInteger()
    private val inUse: MutableSet<ByteBuffer> = Collections.synchronizedSet(
        Collections.newSetFromMap(IdentityHashMap()),
    )

    /** Buffers that are in use. */
    internal val outstanding: Int get() = inUse.size

    /** A cleared buffer, or null when all are in use: then the caller delivers [LostSamples], [DropReason.NO_BUFFER]. */
    public fun acquire(): ByteBuffer? = (free.poll() ?: allocate())?.clear()?.also(inUse::add)

    /** A cleared buffer, after waiting for one when all are in use; blocks, for sources that can wait. */
    public fun take(): ByteBuffer = acquire() ?: free.take().clear().also(inUse::add)

    /** Gives back a buffer of this pool; the caller no longer touches it. */
    public fun giveBack(buffer: ByteBuffer) {
        check(inUse.remove(buffer)) { "a buffer is given back that is not in use, or not of this pool" }
        free.add(buffer)
    }

    private fun allocate(): ByteBuffer? {
        val number = allocated.getAndUpdate { minOf(it + 1, count) }
        return if (number < count) ByteBuffer.allocateDirect(bufferBytes).order(ByteOrder.LITTLE_ENDIAN) else null
    }
}
