package dev.ml2sensors.transport

import java.net.InetSocketAddress
import java.nio.channels.SocketChannel

/**
 * The send queue of one TCP connection: the kernel keeps what was written until the peer acknowledges it. Java cannot
 * read its length; libml2sensors.so asks the kernel. Thread-safe.
 */
internal class SendQueue private constructor(private val descriptor: Int) {
    /** Its length in bytes. Must not be read after the connection is closed. */
    val bytes: Int get() = unacknowledged(descriptor).coerceAtLeast(0)

    companion object {
        /** Returns the queue of a connected [socket]; null if the system does not tell it, or without libml2sensors.so. */
        fun of(socket: SocketChannel): SendQueue? {
            val descriptor = try {
                find(portOf(socket.localAddress), portOf(socket.remoteAddress))
            } catch (_: UnsatisfiedLinkError) {
                return null
            }
            return if (descriptor < 0) null else SendQueue(descriptor)
        }

        private fun portOf(address: Any?) = (address as InetSocketAddress).port

        // Registered by JNI_OnLoad
        @JvmStatic
        private external fun find(localPort: Int, remotePort: Int): Int

        @JvmStatic
        private external fun unacknowledged(descriptor: Int): Int
    }
}
