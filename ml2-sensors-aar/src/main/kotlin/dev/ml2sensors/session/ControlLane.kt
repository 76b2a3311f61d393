package dev.ml2sensors.session

import dev.ml2sensors.wire.Bye
import dev.ml2sensors.wire.ControlJson
import dev.ml2sensors.wire.ErrorBody
import dev.ml2sensors.wire.ErrorCode
import dev.ml2sensors.wire.Frame
import dev.ml2sensors.wire.FrameKind
import dev.ml2sensors.wire.ProtocolException
import dev.ml2sensors.wire.RosLanes
import dev.ml2sensors.wire.Welcome
import kotlinx.coroutines.CancellationException
import kotlinx.coroutines.NonCancellable
import kotlinx.coroutines.async
import kotlinx.coroutines.coroutineScope
import kotlinx.coroutines.delay
import kotlinx.coroutines.sync.Mutex
import kotlinx.coroutines.sync.withLock
import kotlinx.coroutines.withContext
import kotlinx.coroutines.withTimeoutOrNull
import java.io.EOFException
import java.io.IOException
import kotlin.time.Duration.Companion.milliseconds
import kotlin.time.Duration.Companion.seconds
import kotlin.time.TimeMark
import kotlin.time.TimeSource

/** The control connection of a session, with keep-alive and an orderly end. Read by one coroutine, written by any. */
internal class ControlLane(private val connection: Connection) {
    private val silence = Silence()

    @Volatile
    private var lastSent: TimeMark = TimeSource.Monotonic.markNow()

    private val writing = Mutex()

    /** Knows the kinds of openings from now on. */
    fun allowOpenings(): Unit = connection.allowOpenings(RosLanes.maxMessageBytes(RosLanes.ROS))

    /** True once [finish] has begun; from then on errors of connections do not matter. */
    @Volatile
    var byeWritten = false
        private set

    suspend inline fun <reified T> write(kind: FrameKind, body: T): Unit = write(kind, ControlJson.encode(body))

    /** Writes a frame; nothing is written after BYE. */
    suspend fun write(kind: FrameKind, body: ByteArray = EMPTY): Unit =
        writing.withLock { if (!byeWritten) writeNow(kind, body) }

    private suspend fun writeNow(kind: FrameKind, body: ByteArray) {
        lastSent = TimeSource.Monotonic.markNow()
        // An interrupted write closes the connection, and the receiver could not be told why the session ends
        withContext(NonCancellable) {
            withTimeoutOrNull(WRITE_LIMIT) { blockingIo { connection.writer.write(kind, body) } }
        } ?: throw IOException("the receiver has not read $kind within $WRITE_LIMIT")
    }

    /**
     * Waits for the next frame of one of the [allowed] kinds; returns null when the receiver closed the connection
     * after our BYE. Cancelling ends the input only, so the receiver can still be told why the session ends.
     */
    suspend fun read(allowed: Set<FrameKind>): Frame? {
        val result = coroutineScope {
            val reading = async(blockingThreads) { runCatching { connection.read(allowed) } }
            try {
                reading.await()
            } catch (e: CancellationException) {
                connection.shutdownInput()
                throw e
            }
        }
        val frame = result.getOrThrow()
        if (frame == null && !byeWritten) throw EOFException("the receiver closed the connection")
        silence.end()
        return frame
    }

    /** Sends PING when nothing was sent for a while; fails when the receiver is silent. */
    suspend fun keepAlive(timeouts: Welcome.Timeouts) {
        while (true) {
            delay(TICK)
            val silent = silence.lasted()
            if (silent > timeouts.deadSeconds.seconds) {
                throw ProtocolException(ErrorCode.TIMEOUT, "no frame from the receiver for $silent")
            }
            if (lastSent.elapsedNow() >= timeouts.pingSeconds.seconds) write(FrameKind.PING)
        }
    }

    /** Sends BYE; nothing is written afterwards. */
    suspend fun finish(reason: String): Unit = writing.withLock {
        byeWritten = true
        writeNow(FrameKind.BYE, ControlJson.encode(Bye.of(reason)))
        withTimeoutOrNull(WRITE_LIMIT) { blockingIo { connection.shutdownOutput() } }
    }

    /** Sends [error] to the peer, if the connection still works. */
    suspend fun sendError(error: ProtocolException) {
        try {
            withTimeoutOrNull(CLOSING_LIMIT) {
                write(FrameKind.ERROR, ErrorBody.of(error.code, error.message.orEmpty(), fatal = true))
                blockingIo {
                    connection.shutdownOutput()
                    connection.discard()
                }
            }
        } catch (lost: IOException) {
            error.addSuppressed(lost)
        }
    }

    companion object {
        /** Input is read for this long after the last frame was sent, PROTOCOL.md. */
        val CLOSING_LIMIT = 1.seconds
        private val EMPTY = ByteArray(0)
        private val TICK = 250.milliseconds
        private val WRITE_LIMIT = 3.seconds
    }
}
