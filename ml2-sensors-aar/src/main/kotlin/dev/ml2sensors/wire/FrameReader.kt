package dev.ml2sensors.wire

import java.io.EOFException
import java.nio.ByteBuffer
import java.nio.channels.ReadableByteChannel

/**
 * Reads whole frames from a blocking channel; used by one thread. A large body arrives in a buffer of a pool, so that
 * nothing is left of it but its bytes.
 */
internal class FrameReader(
    private val source: ReadableByteChannel,
    private val buffers: LargeBuffers = LargeBuffers.SHARED,
) {
    /** The greatest MESSAGE of the connection; 0 if the session does not know the kinds of openings. */
    @Volatile
    var maxMessageBytes: Int = 0

    private val header = ByteBuffer.allocateDirect(FrameHeader.BYTES)

    /** The number of skipped frames of unknown kinds. */
    var skipped: Long = 0
        private set

    /**
     * Waits for the next frame of a known kind; returns null at the end of the stream between two frames.
     *
     * @param allowed the kinds that the peer may send now; ERROR is always allowed.
     * @throws ProtocolException when the bytes are not a frame of this version, or of a kind that is not allowed.
     * @throws EOFException when the stream ends inside a frame.
     */
    fun next(allowed: Set<FrameKind>): Frame? {
        while (true) {
            header.clear()
            if (!fill(header, endAllowed = true)) return null
            val parsed = FrameHeader.read(header.flip(), ::maxLength)
            val kind = known(parsed.kind)
            if (kind != null && kind != FrameKind.ERROR && kind !in allowed) {
                throw ProtocolException(ErrorCode.UNEXPECTED, "expected one of $allowed, found $kind")
            }
            val body = readBody(parsed.length)
            if (kind != null) return Frame(kind, parsed, body)
            skipped++
        }
    }

    private fun known(kind: FrameKind?) = kind?.takeIf { maxMessageBytes > 0 || !it.isOfOpenings }

    private fun maxLength(kind: FrameKind?): Int {
        val known = known(kind)
        return if (known == FrameKind.MESSAGE) maxMessageBytes else FrameKind.maxLength(known)
    }

    private fun readBody(length: Int): ByteArray {
        if (length <= CHUNK_BYTES) return ByteArray(length).also { fill(ByteBuffer.wrap(it), endAllowed = false) }
        var buffer = buffers.acquire()
        try {
            while (true) {
                fill(buffer.limit(minOf(length, buffer.capacity())), endAllowed = false)
                if (buffer.limit() == length) break
                buffer = ByteBuffer.allocateDirect(buffer.capacity() * 2).put(buffer.flip())
            }
            return ByteArray(length).also { buffer.flip().get(it) }
        } finally {
            buffers.release(buffer)
        }
    }

    private fun fill(target: ByteBuffer, endAllowed: Boolean): Boolean {
        while (target.hasRemaining()) {
            if (source.read(target) >= 0) continue
            if (endAllowed && target.position() == 0) return false
            throw EOFException("expected ${target.remaining()} more bytes of a frame, found the end of the stream")
        }
        return true
    }

    private companion object {
        /** The most that is allocated for a body before its bytes arrive, but for what the pool has. */
        const val CHUNK_BYTES = 4096
    }
}

/** Direct buffers that have grown with the bodies before, since only garbage collection frees one. Thread-safe. */
internal class LargeBuffers {
    private val free = ArrayDeque<ByteBuffer>()

    @Synchronized
    fun acquire(): ByteBuffer = free.removeLastOrNull()?.clear() ?: ByteBuffer.allocateDirect(FIRST_BYTES)

    @Synchronized
    fun release(buffer: ByteBuffer) {
        if (free.size < MOST) free.addLast(buffer)
    }

    companion object {
        private const val FIRST_BYTES = 4096

        /** One for each lane of large messages. */
        private const val MOST = 4
        val SHARED = LargeBuffers()
    }
}

/** A received frame. */
internal class Frame(val kind: FrameKind, val header: FrameHeader, val body: ByteArray)
