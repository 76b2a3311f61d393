package dev.ml2sensors.session

import dev.ml2sensors.wire.ErrorCode
import dev.ml2sensors.wire.FrameHeader
import dev.ml2sensors.wire.FrameKind
import dev.ml2sensors.wire.FrameWriter
import dev.ml2sensors.wire.ProtocolException
import kotlinx.coroutines.Job
import kotlinx.coroutines.cancelAndJoin
import kotlinx.coroutines.withTimeoutOrNull
import java.nio.ByteBuffer
import kotlin.random.Random
import kotlin.time.Duration
import kotlin.time.Duration.Companion.seconds
import kotlin.time.TimeSource

/**
 * Sends filler frames that the receiver times, one test at a time; PROTOCOL.md, Link test. Called by one coroutine.
 *
 * @param launch runs a part of the session on a thread that may block.
 * @param join opens the lane, for the first test.
 */
internal class LinkTest(
    private val launch: (suspend () -> Unit) -> Job,
    private val timeSource: TimeSource = TimeSource.Monotonic,
    private val join: suspend () -> FrameWriter,
) {
    private var writer: FrameWriter? = null

    @Volatile
    private var test: Job? = null

    @Volatile
    private var isRunning = false

    @Volatile
    private var isEnding = false

    /** Starts to send [bytes] of filler; does not wait for the end. */
    fun begin(bytes: Int) {
        if (isEnding) return
        if (isRunning) throw ProtocolException(ErrorCode.UNEXPECTED, "expected one LINK_TEST at a time")
        isRunning = true
        test = launch {
            val open = writer ?: join().also { writer = it }
            blockingIo { fill(open, bytes) }
        }
    }

    /** Ends a running test, between two frames if that takes no longer than [limit], and starts no other. */
    suspend fun finish(limit: Duration) {
        isEnding = true
        withTimeoutOrNull(limit) { test?.join() }
        test?.cancelAndJoin()
    }

    private fun fill(writer: FrameWriter, bytes: Int) {
        val end = timeSource.markNow() + LIMIT
        val whole = Filler(WHOLE_BYTES)
        var left = bytes
        while (left > 0 && !isEnding && end.hasNotPassedNow()) {
            val filler = if (left >= WHOLE_BYTES) whole else Filler(left)
            filler.write(writer)
            left -= filler.bytes
        }
        isRunning = false // the receiver may ask again as soon as it has read the end
        Filler(0).write(writer)
    }

    /** One filler frame that can be written repeatedly. */
    private class Filler(val bytes: Int) {
        private val head = ByteBuffer.allocate(FrameHeader.BYTES).also {
            FrameHeader(FrameKind.FILLER.code, bytes).writeTo(it)
        }
        private val noise = NOISE.duplicate().limit(bytes)

        fun write(writer: FrameWriter): Unit = writer.write(head.position(0), noise.position(0))
    }

    private companion object {
        /** PROTOCOL.md, Link test. */
        val LIMIT = 2.seconds
        val WHOLE_BYTES = FrameKind.FILLER.maxLength

        /** Random bytes, which cannot be compressed on the way. */
        val NOISE: ByteBuffer by lazy {
            ByteBuffer.allocateDirect(WHOLE_BYTES).put(Random.nextBytes(WHOLE_BYTES)).flip()
        }
    }
}
