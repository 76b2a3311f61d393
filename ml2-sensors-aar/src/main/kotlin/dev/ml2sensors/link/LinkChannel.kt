package dev.ml2sensors.link

import java.nio.ByteBuffer
import java.nio.channels.GatheringByteChannel
import java.nio.channels.ReadableByteChannel
import java.nio.channels.SocketChannel

/** A blocking connection: one thread reads, any may write, also at once. Interrupts close it. */
internal interface LinkChannel :
    GatheringByteChannel,
    ReadableByteChannel {
    /** Ends the input, so that a thread that waits for some finds the end of the stream. */
    fun finishReading()

    /** Tells the peer that nothing more will come. */
    fun finishWriting()
}

/** A connection as it is. */
internal class PlainChannel(private val socket: SocketChannel) : LinkChannel {
    override fun read(target: ByteBuffer): Int = socket.read(target)

    override fun write(source: ByteBuffer): Int = socket.write(source)

    override fun write(sources: Array<out ByteBuffer>): Long = socket.write(sources)

    override fun write(sources: Array<out ByteBuffer>, offset: Int, length: Int): Long =
        socket.write(sources, offset, length)

    override fun finishReading() {
        if (socket.isOpen) socket.shutdownInput()
    }

    override fun finishWriting() {
        if (socket.isOpen) socket.shutdownOutput()
    }

    override fun isOpen(): Boolean = socket.isOpen

    override fun close(): Unit = socket.close()
}
