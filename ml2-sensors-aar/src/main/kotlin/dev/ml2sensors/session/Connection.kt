package dev.ml2sensors.session

import dev.ml2sensors.pacing.ImagePacing
import dev.ml2sensors.transport.PlaintextChannel
import dev.ml2sensors.transport.SendQueue
import dev.ml2sensors.transport.TransportChannel
import dev.ml2sensors.transport.TransportException
import dev.ml2sensors.transport.TransportSecurity
import dev.ml2sensors.wire.ControlJson
import dev.ml2sensors.wire.ErrorBody
import dev.ml2sensors.wire.ErrorCode
import dev.ml2sensors.wire.Frame
import dev.ml2sensors.wire.FrameKind
import dev.ml2sensors.wire.FrameReader
import dev.ml2sensors.wire.FrameWriter
import dev.ml2sensors.wire.ProtocolException
import dev.ml2sensors.wire.printable
import java.io.Closeable
import java.net.InetAddress
import java.net.StandardSocketOptions
import java.nio.ByteBuffer
import java.nio.channels.SocketChannel

/**
 * Reads and writes frames over one blocking connection to the receiver. One thread reads, any may write; interrupting a
 * thread closes the connection.
 *
 * @property address the receiver's address that answered.
 */
internal class Connection private constructor(
    private val channel: TransportChannel,
    queue: SendQueue?,
    val address: InetAddress,
    private val pacing: ImagePacing?,
    rosNowNanos: () -> Long,
) : Closeable {
    private val reader = FrameReader(channel)
    private val unacknowledged = queue?.takeIf { pacing != null }?.let { it::bytes }?.also { pacing?.add(it) }
    val writer: FrameWriter = FrameWriter(channel, pacing, rosNowNanos)

    /**
     * Waits for the next frame of one of the [allowed] kinds, and returns null at the end of the stream. Skips an ERROR
     * that is not fatal, unless it is allowed.
     *
     * @throws ProtocolException also when the frame is a fatal ERROR, with the peer's code and message.
     */
    fun read(allowed: Set<FrameKind>): Frame? {
        while (true) {
            val frame = reader.next(allowed) ?: return null
            if (frame.kind != FrameKind.ERROR) return frame
            val error = decodeError(frame.body)
            val code = ErrorCode.entries.firstOrNull { it.wireName == error.code } ?: ErrorCode.UNEXPECTED
            val text = printable("${error.code}: ${error.message}")
            if (error.fatal) throw ProtocolException(code, "the receiver says $text", true)
            if (FrameKind.ERROR in allowed) return frame
        }
    }

    /** Knows the kinds of openings from now on, with messages of at most [bytes]. */
    fun allowOpenings(bytes: Int) {
        reader.maxMessageBytes = bytes
    }

    /** Reads and discards input until the end of the stream. */
    fun discard() {
        val sink = ByteBuffer.allocate(DISCARD_BYTES)
        do sink.clear() while (channel.read(sink) >= 0)
    }

    private fun decodeError(body: ByteArray): ErrorBody = try {
        ControlJson.decode(body)
    } catch (e: ProtocolException) {
        throw ProtocolException(e.code, "the receiver sent an ERROR with an invalid body: ${e.message}", isPeers = true)
    }

    /** Ends the input: a thread in [read] finds the end of the stream. */
    fun shutdownInput(): Unit = channel.shutdownInput()

    /** Ends the output, unless the connection is closed. Blocks while the peer does not read. */
    fun shutdownOutput(): Unit = channel.shutdownOutput()

    override fun close() {
        if (unacknowledged != null) pacing?.remove(unacknowledged)
        channel.close()
    }

    companion object {
        private const val DISCARD_BYTES = 4096

        /** DSCP 48 in the upper six bits, RFC 2474. */
        private const val CS6 = 48 shl 2

        /** A link of 10 Mbit/s delivers this in 13 ms. Small frames that do not fit wait, and are written together. */
        private const val URGENT_UNSENT_BYTES = 16 * 1024

        /** A quarter of a raw world camera frame. */
        private const val BULK_UNSENT_BYTES = 256 * 1024

        /** Two turns of a paced lane: what is in the kernel when the link becomes slower goes before small messages. */
        private const val PACED_UNSENT_BYTES = 2 * ImagePacing.SLICE_BYTES

        /**
         * Connects to the first of the receiver's addresses that answers. An [urgent] connection is marked DSCP CS6, so
         * that an access point can prefer it to images. The kernel holds little that it has not sent, so that nothing
         * becomes stale there.
         *
         * @param pacing paces the images of this connection, unless it stays on this machine.
         * @param resolve returns the addresses of a host.
         * @throws TransportException when this device is not paired, or the machine that answers is not the receiver
         * that [security] and the address require.
         */
        fun open(
            receiver: ReceiverAddress,
            security: TransportSecurity,
            rosNowNanos: () -> Long,
            urgent: Boolean = true,
            pacing: ImagePacing? = null,
            resolve: (String) -> List<InetAddress> = ::addressesOf,
        ): Connection {
            // Fails here if the device is not paired
            val client = (security as? TransportSecurity.Paired)?.client
            return firstThatAnswers(receiver, resolve(receiver.host)) { address, limitMillis ->
                val socket = SocketChannel.open()
                try {
                    socket.setOption(StandardSocketOptions.TCP_NODELAY, true)
                    if (urgent) socket.setOption(StandardSocketOptions.IP_TOS, CS6)
                    val paced = pacing.takeUnless { address.address.isLoopbackAddress }
                    socket.socket().connect(address, limitMillis)
                    val unsentBytes = when {
                        urgent -> URGENT_UNSENT_BYTES
                        paced == null -> BULK_UNSENT_BYTES
                        else -> PACED_UNSENT_BYTES
                    }
                    val queue = SendQueue.of(socket)
                    if (queue?.limitUnsent(unsentBytes) != true) {
                        // It bounds what is under way, too, and a long path needs more of that
                        socket.setOption(StandardSocketOptions.SO_SNDBUF, 4 * unsentBytes)
                    }
                    val channel = client?.open(socket, "$receiver", receiver.fingerprint) ?: PlaintextChannel(socket)
                    Connection(channel, queue, address.address, paced, rosNowNanos)
                } catch (e: Throwable) {
                    socket.close()
                    throw e
                }
            }
        }
    }
}
