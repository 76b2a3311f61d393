package dev.ml2sensors.session

import dev.ml2sensors.wire.Bye
import dev.ml2sensors.wire.ControlJson
import dev.ml2sensors.wire.ErrorBody
import dev.ml2sensors.wire.ErrorCode
import dev.ml2sensors.wire.Frame
import dev.ml2sensors.wire.FrameKind
import dev.ml2sensors.wire.ProtocolException
import dev.ml2sensors.wire.Welcome
import kotlinx.coroutines.Dispatchers
import kotlinx.coroutines.delay
import kotlinx.coroutines.runInterruptible
import java.io.EOFException
import java.io.IOException
import kotlin.time.Duration.Companion.milliseconds
import kotlin.time.Duration.Companion.seconds
import kotlin.time.TimeMark
import kotlin.time.TimeSource

/** The control connection of a session: who spoke when, and orderly ends. Read by one coroutine, written by any. */
internal class ControlLane(private val connection: Connection) {
    @Volatile
    private var lastHeard: TimeMark = TimeSource.Monotonic.markNow()

    @Volatile
    private var lastSpoke: TimeMark = lastHeard

    @Volatile
    private var saidBye = false

    suspend inline fun <reified T> write(kind: FrameKind, body: T): Unit = write(kind, ControlJson.encode(body))

    suspend fun write(kind: FrameKind, body: ByteArray = EMPTY) {
        lastSpoke = TimeSource.Monotonic.markNow()
        runInterruptible(Dispatchers.IO) { connection.writer.write(kind, body) }
    }

    /** The next frame; null when the receiver closed the connection after our BYE. */
    suspend fun read(): Frame? {
        val frame = try {
            runInterruptible(Dispatchers.IO) { connection.read() }
        } catch (e: EOFException) {
            if (saidBye) return null
            throw e
        }
        lastHeard = TimeSource.Monotonic.markNow()
        return frame
    }

    /** Pings when we were silent; fails when the peer is. */
    suspend fun keepAlive(timeouts: Welcome.Timeouts) {
        while (true) {
            delay(TICK)
            val silence = lastHeard.elapsedNow()
            if (silence > timeouts.deadSeconds.seconds) {
                throw ProtocolException(ErrorCode.TIMEOUT, "nothing heard from the receiver for $silence")
            }
            if (lastSpoke.elapsedNow() >= timeouts.pingSeconds.seconds) write(FrameKind.PING)
        }
    }

    /** Says goodbye: nothing more will be written. */
    suspend fun finish(reason: String) {
        saidBye = true
        write(FrameKind.BYE, Bye(reason))
        connection.finishWriting()
    }

    /** Tells the peer why the session ends. Best effort: the connection may be what failed. */
    suspend fun tell(error: ProtocolException) {
        try {
            write(FrameKind.ERROR, ErrorBody(error.code.wireName, error.message.orEmpty(), fatal = true))
            connection.finishWriting()
        } catch (lost: IOException) {
            error.addSuppressed(lost)
        }
    }

    private companion object {
        val EMPTY = ByteArray(0)
        val TICK = 250.milliseconds
    }
}
