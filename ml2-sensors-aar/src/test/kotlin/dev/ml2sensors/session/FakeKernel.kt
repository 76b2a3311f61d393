package dev.ml2sensors.session

import dev.ml2sensors.wire.FrameHeader
import dev.ml2sensors.wire.FrameWriter
import java.io.IOException
import java.nio.ByteBuffer
import java.nio.channels.GatheringByteChannel
import java.util.concurrent.CopyOnWriteArrayList
import java.util.concurrent.Semaphore

/** The sending side of a connection that takes a write for every permit, and blocks in between. */
internal class FakeKernel(private val open: Boolean = false) {
    /** The sequences of the frames of each write. */
    val writes = CopyOnWriteArrayList<List<Int>>()
    val sequences: List<Int> get() = writes.flatten()

    /** The lengths of the bodies. */
    val lengths = CopyOnWriteArrayList<Int>()
    private val permits = Semaphore(0)
    private val entered = Semaphore(0)
    private val written = Semaphore(0)

    @Volatile
    private var isBroken = false

    fun open(frames: Int) = permits.release(frames)

    fun breakDown() {
        isBroken = true
        permits.release()
    }

    /** Waits until a write has begun that no earlier call has waited for. */
    fun awaitEntered() = entered.acquire()

    fun awaitWrites(total: Int) {
        while (writes.size < total) written.acquire()
    }

    fun writer(): FrameWriter = FrameWriter(channel) { 0 }

    private val channel = object : GatheringByteChannel {
        override fun write(sources: Array<out ByteBuffer>, offset: Int, length: Int): Long {
            await()
            val header = FrameHeader.read(sources[0].duplicate())
            lengths += header.length
            writes += listOf(header.sequence)
            val count = sources.sumOf { it.remaining() }
            sources.forEach { it.position(it.limit()) }
            written.release()
            return count.toLong()
        }

        private fun await() {
            entered.release()
            if (!open) permits.acquire()
            if (isBroken) throw IOException("broken")
        }

        override fun write(sources: Array<out ByteBuffer>) = write(sources, 0, sources.size)

        /** Frames whose bodies follow their headers. */
        override fun write(source: ByteBuffer): Int {
            await()
            val count = source.remaining()
            val sequences = ArrayList<Int>()
            while (source.hasRemaining()) {
                val header = FrameHeader.read(source)
                source.position(source.position() + header.length)
                lengths += header.length
                sequences += header.sequence
            }
            writes += sequences
            written.release()
            return count
        }

        override fun isOpen() = true

        override fun close() = Unit
    }
}
