package dev.ml2sensors.session

import dev.ml2sensors.wire.ControlJson
import dev.ml2sensors.wire.ErrorBody
import dev.ml2sensors.wire.ErrorCode
import dev.ml2sensors.wire.Frame
import dev.ml2sensors.wire.FrameKind
import dev.ml2sensors.wire.FrameReader
import dev.ml2sensors.wire.FrameWriter
import dev.ml2sensors.wire.ProtocolException
import java.io.Closeable
import java.io.EOFException
import java.net.InetSocketAddress
import java.net.StandardSocketOptions
import java.nio.channels.SocketChannel

/** One blocking TCP connection to the receiver: one thread reads it, any may write. Interrupts close it. */
internal class Connection private constructor(private val socket: SocketChannel, rosNowNanos: () -> Long) : Closeable {
    private val reader = FrameReader(socket)
    val writer: FrameWriter = FrameWriter(socket, rosNowNanos)

    /**
     * Waits for the next frame.
     *
     * @throws ProtocolException also when the frame is a fatal ERROR: with the peer's code and words.
     * @throws EOFException at the end of the stream.
     */
    fun read(): Frame {
        val frame = reader.next() ?: throw EOFException("the receiver closed the connection")
        if (frame.kind == FrameKind.ERROR) {
            val error = ControlJson.decode<ErrorBody>(frame.body)
            val code = ErrorCode.entries.firstOrNull { it.wireName == error.code } ?: ErrorCode.UNEXPECTED
            if (error.fatal) throw ProtocolException(code, "the receiver says ${error.code}: ${error.message}", true)
        }
        return frame
    }

    inline fun <reified T> write(kind: FrameKind, body: T): Unit = writer.write(kind, ControlJson.encode(body))

    /** Waits for the next frame, which must be of [kind], and gives its body. */
    inline fun <reified T> expect(kind: FrameKind): T {
        val frame = read()
        if (frame.kind != kind) {
            throw ProtocolException(ErrorCode.UNEXPECTED, "expected $kind, found ${frame.kind}")
        }
        return ControlJson.decode<T>(frame.body)
    }

    /** Tells the peer that nothing more will come. */
    fun finishWriting() {
        socket.shutdownOutput()
    }

    override fun close() {
        socket.close()
    }

    companion object {
        /**
         * Connects; [sendBufferBytes] bounds what the kernel holds of a lane whose frames grow stale, null leaves it to
         * the platform.
         */
        fun open(receiver: ReceiverAddress, rosNowNanos: () -> Long, sendBufferBytes: Int? = null): Connection {
            val socket = SocketChannel.open()
            try {
                socket.setOption(StandardSocketOptions.TCP_NODELAY, true)
                if (sendBufferBytes != null) socket.setOption(StandardSocketOptions.SO_SNDBUF, sendBufferBytes)
                socket.connect(InetSocketAddress(receiver.host, receiver.port))
                return Connection(socket, rosNowNanos)
            } catch (e: Throwable) {
                socket.close()
                throw e
            }
        }
    }
}
