package dev.ml2sensors.transport

import java.io.Closeable
import java.io.InputStream
import java.net.InetAddress
import java.net.ServerSocket
import java.net.Socket
import kotlin.concurrent.thread

/** A wire that passes at most [pieceBytes] at once, and what it is told to [inject]. */
internal class Relay(private val target: Int, private val pieceBytes: Int) : Closeable {
    private val server = ServerSocket(0, 1, InetAddress.getLoopbackAddress())
    private val device = thread(start = false, isDaemon = true) { pass() }
    private lateinit var toDevice: Socket
    val port: Int get() = server.localPort

    init {
        device.start()
    }

    private fun pass() {
        toDevice = server.accept().apply { tcpNoDelay = true }
        val receiver = Socket(InetAddress.getLoopbackAddress(), target).apply { tcpNoDelay = true }
        thread(isDaemon = true) { runCatching { copy(toDevice.getInputStream(), receiver) } }
        runCatching { copy(receiver.getInputStream(), toDevice) }
    }

    /** Puts [bytes] between those of the receiver. */
    fun inject(bytes: ByteArray) = toDevice.getOutputStream().write(bytes)

    private fun copy(from: InputStream, to: Socket) {
        val piece = ByteArray(pieceBytes)
        while (true) {
            val count = from.read(piece)
            if (count < 0) break
            to.getOutputStream().write(piece, 0, count)
        }
        to.shutdownOutput()
    }

    override fun close(): Unit = server.close()
}
