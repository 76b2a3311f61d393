package dev.ml2sensors.session

import dev.ml2sensors.transport.PlaintextChannel
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
import kotlinx.coroutines.Dispatchers
import kotlinx.coroutines.currentCoroutineContext
import kotlinx.coroutines.ensureActive
import kotlinx.coroutines.runInterruptible
import java.io.Closeable
import java.io.IOException
import java.net.InetAddress
import java.net.StandardSocketOptions
import java.nio.ByteBuffer
import java.nio.channels.SocketChannel

/**
 * Frames over one blocking connection to the receiver: one thread reads it, any may write. Interrupts close it.
 *
 * @property address the one of the receiver's that answered.
 */
internal class Connection private constructor(
    private val channel: TransportChannel,
    val address: InetAddress,
    rosNowNanos: () -> Long,
) : Closeable {
    private val reader = FrameReader(channel)
    val writer: FrameWriter = FrameWriter(channel, rosNowNanos)

    /**
     * Waits for the next frame of one of the kinds [allowed]; null at the end of the stream. An ERROR that is not fatal
     * is passed over.
     *
     * @throws ProtocolException also when the frame is a fatal ERROR: with the peer's code and words.
     */
    fun read(allowed: Set<FrameKind>): Frame? {
        while (true) {
            val frame = reader.next(allowed) ?: return null
            if (frame.kind != FrameKind.ERROR) return frame
            val error = decodeError(frame.body)
            val code = ErrorCode.entries.firstOrNull { it.wireName == error.code } ?: ErrorCode.UNEXPECTED
            if (error.fatal) throw ProtocolException(code, "the receiver says ${error.code}: ${error.message}", true)
            if (FrameKind.ERROR in allowed) return frame
        }
    }

    /** Reads what still arrives, and throws it away. */
    fun discard() {
        val sink = ByteBuffer.allocate(DISCARD_BYTES)
        do sink.clear() while (channel.read(sink) >= 0)
    }

    private fun decodeError(body: ByteArray): ErrorBody = try {
        ControlJson.decode(body)
    } catch (e: ProtocolException) {
        throw ProtocolException(e.code, "the receiver's ERROR is none: ${e.message}", isPeers = true)
    }

    /** Ends the input, so that a thread that waits in [read] finds the end of the stream. */
    fun shutdownInput(): Unit = channel.shutdownInput()

    /** Tells the peer that nothing more will come, unless it is closed; blocks while the peer does not read. */
    fun shutdownOutput(): Unit = channel.shutdownOutput()

    override fun close(): Unit = channel.close()

    companion object {
        private const val DISCARD_BYTES = 4096

        /** DSCP 48 in the upper six bits, RFC 2474. */
        private const val CS6 = 48 shl 2

        /** A quarter of a raw world camera frame. */
        private const val BULK_SEND_BUFFER_BYTES = 256 * 1024

        /**
         * Connects to the first of the receiver's addresses that answers. An [urgent] connection is marked DSCP CS6, so
         * that an access point may let it pass images; of any other the kernel holds little, so that images do not grow
         * stale there.
         *
         * @param resolve gives the addresses of a host.
         * @throws TransportException when what answers is not the receiver that [security] and the address ask for.
         */
        fun open(
            receiver: ReceiverAddress,
            security: TransportSecurity,
            rosNowNanos: () -> Long,
            urgent: Boolean = true,
            resolve: (String) -> List<InetAddress> = ::addressesOf,
        ): Connection = firstThatAnswers(receiver, resolve(receiver.host)) { address, limitMillis ->
            val socket = SocketChannel.open()
            try {
                socket.setOption(StandardSocketOptions.TCP_NODELAY, true)
                if (urgent) {
                    socket.setOption(StandardSocketOptions.IP_TOS, CS6)
                } else {
                    socket.setOption(StandardSocketOptions.SO_SNDBUF, BULK_SEND_BUFFER_BYTES)
                }
                socket.socket().connect(address, limitMillis)
                Connection(security.channel(socket, receiver), address.address, rosNowNanos)
            } catch (e: Throwable) {
                socket.close()
                throw e
            }
        }

        private fun TransportSecurity.channel(socket: SocketChannel, receiver: ReceiverAddress) = when (this) {
            is TransportSecurity.Paired -> client.open(socket, "$receiver", receiver.fingerprint)
            is TransportSecurity.Insecure -> PlaintextChannel(socket)
        }
    }
}

/**
 * Runs [block], which may block on connections, where it may. Cancelling closes a connection that it waits for; that
 * this then fails is no failure.
 */
internal suspend fun <T> blockingIo(block: () -> T): T = try {
    runInterruptible(Dispatchers.IO, block)
} catch (e: IOException) {
    currentCoroutineContext().ensureActive()
    throw e
}
