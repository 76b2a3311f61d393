package dev.ml2sensors.transport

import java.io.EOFException
import java.io.IOException
import java.nio.ByteBuffer
import java.nio.channels.ClosedChannelException
import java.nio.channels.SocketChannel
import javax.net.ssl.SSLEngine
import javax.net.ssl.SSLEngineResult.HandshakeStatus
import javax.net.ssl.SSLEngineResult.Status
import javax.net.ssl.SSLException

/**
 * TLS over a blocking [socket]. Data is encrypted from the caller's memory into a buffer that goes to the kernel,
 * several records at a time; there is no other copy.
 *
 * The end of the stream without a close_notify is an ordinary end: frames and BYE show whether something is missing.
 *
 * @param receiver its address, for messages.
 */
internal class TlsChannel(
    private val socket: SocketChannel,
    private val engine: SSLEngine,
    private val receiver: String,
) : TransportChannel {
    private val reading = Any()
    private val writing = Any()

    // Guarded by reading: what came from the socket, what of it was decrypted; both ready to be read.
    private var incoming: ByteBuffer? = DirectBufferPool.acquire().limit(0)
    private var decrypted: ByteBuffer? = DirectBufferPool.acquire().limit(0)

    /** Guarded by writing: what goes to the socket. */
    private var outgoing: ByteBuffer? = DirectBufferPool.acquire()

    /** False as long as the receiver can still refuse our certificate, which TLS 1.3 reports after the handshake. */
    private var hasReceived = false

    /** Android's engine decrypts nothing after our close_notify; from then on input is discarded. */
    @Volatile
    private var isOutputShutDown = false

    private val empty = ByteBuffer.allocate(0)

    /**
     * Runs the handshake.
     *
     * @throws TransportException when the peer does not use TLS.
     * @throws SSLException when the handshake fails; the alert is sent to the peer.
     */
    fun handshake() {
        try {
            engine.beginHandshake()
            while (true) {
                when (engine.handshakeStatus) {
                    HandshakeStatus.NEED_WRAP -> wrapEmpty()
                    HandshakeStatus.NEED_TASK -> runTasks()
                    HandshakeStatus.FINISHED, HandshakeStatus.NOT_HANDSHAKING -> return
                    else -> synchronized(reading) { handshakeStep() }
                }
            }
        } catch (e: SSLException) {
            sendAlert(e)
            throw e
        }
    }

    private fun handshakeStep() {
        val result = engine.unwrap(requireOpen(incoming), requireOpen(decrypted).clear())
        decrypted?.flip()
        val hasEnded = if (result.status == Status.BUFFER_UNDERFLOW) !receive() else result.status == Status.CLOSED
        if (hasEnded) {
            throw EOFException("the receiver at $receiver closed the connection in the handshake of TLS")
        }
        val next = requireOpen(incoming)
        val isRecord = !next.hasRemaining() || next.get(next.position()) in TLS_RECORDS
        if (!isRecord) throw PlaintextReceiverException(receiver)
    }

    override fun read(target: ByteBuffer): Int = synchronized(reading) {
        if (!target.hasRemaining()) return 0
        while (!requireOpen(decrypted).hasRemaining()) if (!decrypt()) return -1
        val source = requireOpen(decrypted)
        val count = minOf(source.remaining(), target.remaining())
        val limit = source.limit()
        target.put(source.limit(source.position() + count))
        source.limit(limit)
        count
    }

    /** Decrypts one record or receives more input; returns false at the end of the stream. */
    private fun decrypt(): Boolean {
        val result = try {
            engine.unwrap(requireOpen(incoming), requireOpen(decrypted).clear())
        } catch (e: SSLException) {
            if (!hasReceived) throw NotPairedException("the receiver at $receiver", e)
            throw TlsException(receiver, e.message ?: e.javaClass.simpleName, e)
        } finally {
            decrypted?.flip()
        }
        if (requireOpen(decrypted).hasRemaining()) hasReceived = true
        when (result.handshakeStatus) {
            HandshakeStatus.NEED_TASK -> runTasks()
            HandshakeStatus.NEED_WRAP -> wrapEmpty()
            else -> Unit
        }
        return when (result.status) {
            Status.BUFFER_UNDERFLOW -> receive()
            Status.CLOSED -> requireOpen(decrypted).hasRemaining() || (isOutputShutDown && discardInput())
            Status.BUFFER_OVERFLOW -> error("a TLS record of more than ${DirectBufferPool.BUFFER_BYTES} bytes")
            else -> true
        }
    }

    private fun discardInput(): Boolean {
        requireOpen(incoming).run { position(limit()) }
        return receive()
    }

    private fun receive(): Boolean {
        val buffer = requireOpen(incoming).compact()
        try {
            return socket.read(buffer) >= 0
        } finally {
            buffer.flip()
        }
    }

    override fun write(sources: Array<out ByteBuffer>, offset: Int, length: Int): Long = synchronized(writing) {
        var count = 0L
        while (hasRemaining(sources, offset, length)) count += encrypt(sources, offset, length)
        count
    }

    /** Encrypts as many records as fit into the buffer, and sends them. */
    private fun encrypt(sources: Array<out ByteBuffer>, offset: Int, length: Int): Long {
        val target = requireOpen(outgoing).clear()
        var count = 0L
        do {
            val result = engine.wrap(sources, offset, length, target)
            if (result.status == Status.CLOSED) throw ClosedChannelException()
            count += result.bytesConsumed()
        } while (hasRemaining(sources, offset, length) && target.remaining() >= engine.session.packetBufferSize)
        send()
        return count
    }

    private fun hasRemaining(sources: Array<out ByteBuffer>, offset: Int, length: Int): Boolean {
        for (index in offset until offset + length) if (sources[index].hasRemaining()) return true
        return false
    }

    override fun write(sources: Array<out ByteBuffer>): Long = write(sources, 0, sources.size)

    override fun write(source: ByteBuffer): Int = write(arrayOf(source), 0, 1).toInt()

    private fun wrapEmpty() = synchronized(writing) {
        engine.wrap(empty, requireOpen(outgoing).clear())
        send()
    }

    private fun send() {
        val encrypted = requireOpen(outgoing).flip()
        while (encrypted.hasRemaining()) socket.write(encrypted)
    }

    private fun runTasks() {
        while (true) (engine.delegatedTask ?: return).run()
    }

    /** Sends the engine's alert for [failure]. */
    private fun sendAlert(failure: SSLException) {
        try {
            while (engine.handshakeStatus == HandshakeStatus.NEED_WRAP && !engine.isOutboundDone) wrapEmpty()
        } catch (e: IOException) {
            failure.addSuppressed(e)
        }
    }

    override fun shutdownInput() {
        if (socket.isOpen) socket.shutdownInput()
    }

    override fun shutdownOutput() {
        synchronized(writing) {
            if (!socket.isOpen) return
            isOutputShutDown = true
            engine.closeOutbound()
            while (!engine.isOutboundDone) wrapEmpty()
            socket.shutdownOutput()
        }
    }

    override fun isOpen(): Boolean = socket.isOpen

    /** Closes the socket first, so that threads that wait for it fail, and then releases the buffers. */
    override fun close() {
        socket.close()
        synchronized(reading) {
            incoming?.let(DirectBufferPool::release)
            decrypted?.let(DirectBufferPool::release)
            incoming = null
            decrypted = null
        }
        synchronized(writing) {
            outgoing?.let(DirectBufferPool::release)
            outgoing = null
        }
    }

    private fun requireOpen(buffer: ByteBuffer?): ByteBuffer = buffer ?: throw ClosedChannelException()

    private companion object {
        /** Content types of RFC 8446, B.1. */
        val TLS_RECORDS: Set<Byte> = setOf(20, 21, 22, 23)
    }
}
