package dev.ml2sensors.link

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
 * TLS over a blocking [socket]. What is written is enciphered from the caller's memory into a buffer that goes to the
 * kernel, several records at a time; there is no other copy.
 *
 * The end of the stream without a close_notify is an end like any other: frames and BYE tell whether something is missing.
 *
 * @param receiver where it is, for people.
 */
internal class TlsChannel(
    private val socket: SocketChannel,
    private val engine: SSLEngine,
    private val receiver: String,
) : LinkChannel {
    private val reading = Any()
    private val writing = Any()

    // Guarded by reading: what came from the socket, what of it was deciphered; both ready to be read.
    private var arrived: ByteBuffer? = BufferStock.take().limit(0)
    private var plain: ByteBuffer? = BufferStock.take().limit(0)

    /** Guarded by writing: what goes to the socket. */
    private var leaving: ByteBuffer? = BufferStock.take()

    /** False as long as a refusal of our certificate can still come: TLS 1.3 tells it after the handshake. */
    private var hasHeard = false

    /** Android's engine deciphers nothing after our close_notify: what still comes is passed over, to its end. */
    @Volatile
    private var hasFinished = false

    private val empty = ByteBuffer.allocate(0)

    /**
     * @throws LinkException when the peer speaks no TLS.
     * @throws SSLException when the handshake fails; the peer is told why.
     */
    fun handshake() {
        try {
            engine.beginHandshake()
            while (true) {
                when (engine.handshakeStatus) {
                    HandshakeStatus.NEED_WRAP -> wrapNothing()
                    HandshakeStatus.NEED_TASK -> runTasks()
                    HandshakeStatus.FINISHED, HandshakeStatus.NOT_HANDSHAKING -> return
                    else -> synchronized(reading) { shake() }
                }
            }
        } catch (e: SSLException) {
            tellWhy(e)
            throw e
        }
    }

    private fun shake() {
        val result = engine.unwrap(open(arrived), open(plain).clear())
        plain?.flip()
        val hasEnded = if (result.status == Status.BUFFER_UNDERFLOW) !receive() else result.status == Status.CLOSED
        if (hasEnded) {
            throw EOFException("the receiver at $receiver closed the connection in the handshake of TLS")
        }
        val next = open(arrived)
        val isRecord = !next.hasRemaining() || next.get(next.position()) in TLS_RECORDS
        if (!isRecord) throw PlaintextReceiverException(receiver)
    }

    override fun read(target: ByteBuffer): Int = synchronized(reading) {
        if (!target.hasRemaining()) return 0
        while (!open(plain).hasRemaining()) if (!decipher()) return -1
        val source = open(plain)
        val count = minOf(source.remaining(), target.remaining())
        val limit = source.limit()
        target.put(source.limit(source.position() + count))
        source.limit(limit)
        count
    }

    /** Advances by a record or by what arrives; false at the end of the stream. */
    private fun decipher(): Boolean {
        val result = try {
            engine.unwrap(open(arrived), open(plain).clear())
        } catch (e: SSLException) {
            if (!hasHeard) throw NotPairedException("the receiver at $receiver", e)
            throw TlsException(receiver, e.message ?: e.javaClass.simpleName, e)
        } finally {
            plain?.flip()
        }
        if (open(plain).hasRemaining()) hasHeard = true
        when (result.handshakeStatus) {
            HandshakeStatus.NEED_TASK -> runTasks()
            HandshakeStatus.NEED_WRAP -> wrapNothing()
            else -> Unit
        }
        return when (result.status) {
            Status.BUFFER_UNDERFLOW -> receive()
            Status.CLOSED -> open(plain).hasRemaining() || (hasFinished && passOver())
            Status.BUFFER_OVERFLOW -> error("a TLS record of more than ${BufferStock.BUFFER_BYTES} bytes")
            else -> true
        }
    }

    private fun passOver(): Boolean {
        open(arrived).run { position(limit()) }
        return receive()
    }

    private fun receive(): Boolean {
        val buffer = open(arrived).compact()
        try {
            return socket.read(buffer) >= 0
        } finally {
            buffer.flip()
        }
    }

    override fun write(sources: Array<out ByteBuffer>, offset: Int, length: Int): Long = synchronized(writing) {
        var count = 0L
        while (hasRemaining(sources, offset, length)) count += encipher(sources, offset, length)
        count
    }

    /** As many records as fit the buffer. */
    private fun encipher(sources: Array<out ByteBuffer>, offset: Int, length: Int): Long {
        val target = open(leaving).clear()
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

    private fun wrapNothing() = synchronized(writing) {
        engine.wrap(empty, open(leaving).clear())
        send()
    }

    private fun send() {
        val ciphered = open(leaving).flip()
        while (ciphered.hasRemaining()) socket.write(ciphered)
    }

    private fun runTasks() {
        while (true) (engine.delegatedTask ?: return).run()
    }

    /** Sends the alert that the engine has for [failure]. */
    private fun tellWhy(failure: SSLException) {
        try {
            while (engine.handshakeStatus == HandshakeStatus.NEED_WRAP && !engine.isOutboundDone) wrapNothing()
        } catch (e: IOException) {
            failure.addSuppressed(e)
        }
    }

    override fun finishReading() {
        if (socket.isOpen) socket.shutdownInput()
    }

    override fun finishWriting() {
        synchronized(writing) {
            if (!socket.isOpen) return
            hasFinished = true
            engine.closeOutbound()
            while (!engine.isOutboundDone) wrapNothing()
            socket.shutdownOutput()
        }
    }

    override fun isOpen(): Boolean = socket.isOpen

    /** Whoever waits for the socket fails, and only then the buffers are given back. */
    override fun close() {
        socket.close()
        synchronized(reading) {
            arrived?.let(BufferStock::giveBack)
            plain?.let(BufferStock::giveBack)
            arrived = null
            plain = null
        }
        synchronized(writing) {
            leaving?.let(BufferStock::giveBack)
            leaving = null
        }
    }

    private fun open(buffer: ByteBuffer?): ByteBuffer = buffer ?: throw ClosedChannelException()

    private companion object {
        /** Content types of RFC 8446, B.1. */
        val TLS_RECORDS: Set<Byte> = setOf(20, 21, 22, 23)
    }
}
