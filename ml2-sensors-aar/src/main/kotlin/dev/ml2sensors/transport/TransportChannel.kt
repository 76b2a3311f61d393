package dev.ml2sensors.transport

import java.nio.ByteBuffer
import java.nio.channels.GatheringByteChannel
import java.nio.channels.ReadableByteChannel
import java.nio.channels.SocketChannel

/** A blocking connection. One thread reads, any may write concurrently; interrupting a thread closes it. */
internal interface TransportChannel :
    GatheringByteChannel,
    ReadableByteChannel {
    /** Ends the input: a thread that waits for input finds the end of the stream. */
    fun shutdownInput()

    /** Ends the output: the peer finds the end of the stream. */
    fun shutdownOutput()
}

/** A plaintext connection. */
internal class PlaintextChannel(private val socket: SocketChannel) : TransportChannel {
    override fun read(target: ByteBuffer): Int = socket.read(target)

    override fun write(source: ByteBuffer): Int = socket.write(source)

    override fun write(sources: Array<out ByteBuffer>): Long = socket.write(sources)

    override fun write(sources: Array<out ByteBuffer>, offset: Int, length: Int): Long =
        socket.write(sources, offset, length)

    override fun shutdownInput() {
        if (socket.isOpen) socket.shutdownInput()
    }

    override fun shutdownOutput() {
        if (socket.isOpen) socket.shutdownOutput()
    }

    override fun isOpen(): Boolean = socket.isOpen

    override fun close(): Unit = socket.close()
}
