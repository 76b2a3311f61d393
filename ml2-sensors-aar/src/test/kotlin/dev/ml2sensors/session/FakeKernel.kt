package dev.ml2sensors.session

import dev.ml2sensors.wire.FrameHeader
import dev.ml2sensors.wire.FrameWriter
import java.io.IOException
import java.nio.ByteBuffer
import java.nio.channels.GatheringByteChannel
import java.util.concurrent.CopyOnWriteArrayList
import java.util.concurrent.Semaphore

/** The sending side of a connection that takes a frame for every permit, and blocks in between. */
internal class FakeKernel(private val open: Boolean = false) {
    val sequences = CopyOnWriteArrayList<Int>()

    /** Of the bodies. */
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
        while (sequences.size < total) written.acquire()
    }

    fun writer(): FrameWriter = FrameWriter(channel) { 0 }

    private val channel = object : GatheringByteChannel {
        override fun write(sources: Array<out ByteBuffer>, offset: Int, length: Int): Long {
            entered.release()
            if (!open) permits.acquire()
            if (isBroken) throw IOException("broken")
            val header = FrameHeader.read(sources[0].duplicate())
            lengths += header.length
            sequences += header.sequence
            val count = sources.sumOf { it.remaining() }
            sources.forEach { it.position(it.limit()) }
            written.release()
            return count.toLong()
        }

        override fun write(sources: Array<out ByteBuffer>) = write(sources, 0, sources.size)

        override fun write(source: ByteBuffer) = error("frames are written in one piece")

        override fun isOpen() = true

        override fun close() = Unit
    }
}
