package dev.ml2sensors.transport

import java.io.File
import java.net.InetSocketAddress
import java.nio.channels.SocketChannel

/**
 * The send queue of one TCP connection: the kernel keeps what was written until the peer acknowledges it. Java can
 * neither read nor bound it as TCP does; libml2sensors.so asks the kernel. Thread-safe. Must not be used after the
 * connection is closed.
 */
internal class SendQueue private constructor(private val descriptor: Int) {
    /** Its length in bytes. */
    val bytes: Int get() = unacknowledged(descriptor).coerceAtLeast(0)

    /**
     * Has writes wait while [bytes] of the queue were not sent yet. What is under way is not bounded by it, unlike by a
     * send buffer. Returns false if the system cannot.
     */
    fun limitUnsent(bytes: Int): Boolean = limitUnsent(descriptor, bytes)

    companion object {
        /** Returns the queue of a connected [socket]; null if the system does not tell it, or without libml2sensors.so. */
        fun of(socket: SocketChannel): SendQueue? {
            val local = socket.localAddress as InetSocketAddress
            val remote = socket.remoteAddress as InetSocketAddress
            val descriptor = try {
                find(openFiles(), local.address.address, local.port, remote.address.address, remote.port)
            } catch (_: UnsatisfiedLinkError) {
                return null
            }
            return if (descriptor < 0) null else SendQueue(descriptor)
        }

        /** Returns the descriptors of this process, proc(5); some may be closed meanwhile. */
        private fun openFiles(): IntArray =
            File("/proc/self/fd").list().orEmpty().mapNotNull { it.toIntOrNull() }.toIntArray()

        // Registered by JNI_OnLoad
        @JvmStatic
        private external fun find(
            openFiles: IntArray,
            localAddress: ByteArray,
            localPort: Int,
            remoteAddress: ByteArray,
            remotePort: Int,
        ): Int

        @JvmStatic
        private external fun limitUnsent(descriptor: Int, bytes: Int): Boolean

        @JvmStatic
        private external fun unacknowledged(descriptor: Int): Int
    }
}
