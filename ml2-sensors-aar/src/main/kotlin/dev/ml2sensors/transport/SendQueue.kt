package dev.ml2sensors.transport

import java.net.InetSocketAddress
import java.nio.channels.SocketChannel

/**
 * What the kernel holds of one TCP connection: bytes that were written and that the peer has not acknowledged. Java
 * does not tell, so libml2sensors.so asks the kernel. Thread-safe.
 */
internal class SendQueue private constructor(private val descriptor: Int) {
    /** How many bytes it holds; 0 where the system does not tell. Must not be read after the connection is closed. */
    val bytes: Int get() = unacknowledged(descriptor)

    companion object {
        /** Returns the queue of a connected [socket], or null in a process without libml2sensors.so. */
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
