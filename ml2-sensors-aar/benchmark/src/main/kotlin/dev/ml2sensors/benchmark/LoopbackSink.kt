package dev.ml2sensors.benchmark

import java.io.IOException
import java.net.InetAddress
import java.net.InetSocketAddress
import java.nio.ByteBuffer
import java.nio.channels.ServerSocketChannel
import java.nio.channels.SocketChannel
import kotlin.concurrent.thread

/** A connected TCP socket whose other end, the [peer], reads and forgets; unless [isRead], only from [drain] on. */
internal class LoopbackSink(isRead: Boolean = true) : AutoCloseable {
    val channel: SocketChannel
    val peer: SocketChannel
    private var reader: Thread? = null

    init {
        ServerSocketChannel.open().use { server ->
            server.bind(InetSocketAddress(InetAddress.getLoopbackAddress(), 0))
            channel = SocketChannel.open(server.localAddress)
            peer = server.accept()
        }
        if (isRead) drain()
    }

    fun drain() {
        reader = thread(name = "sink") { peer.use(::drain) }
    }

    override fun close() {
        channel.close()
        reader?.join()
    }

    private fun drain(peer: SocketChannel) {
        val buffer = ByteBuffer.allocateDirect(1 shl 20)
        try {
            do {
                buffer.clear()
            } while (peer.read(buffer) >= 0)
        } catch (_: IOException) {
            // Closed with what the peer has sent, such as session tickets, unread
        }
    }
}
