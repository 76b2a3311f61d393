package dev.ml2sensors.wire

import java.io.EOFException
import java.nio.ByteBuffer
import java.nio.channels.ReadableByteChannel

/**
 * Reads whole frames from a blocking channel; used by one thread. What a receiver sends is small, so bodies are copied.
 */
internal class FrameReader(private val source: ReadableByteChannel) {
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
        var body = ByteBuffer.allocate(minOf(length, CHUNK_BYTES))
        while (true) {
            fill(body, endAllowed = false)
            if (body.capacity() == length) return body.array()
            body = ByteBuffer.allocate(minOf(length, body.capacity() * 2)).put(body.flip())
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
        /** The most that is allocated for a body before its bytes arrive. */
        const val CHUNK_BYTES = 4096
    }
}

/** A received frame. */
internal class Frame(val kind: FrameKind, val header: FrameHeader, val body: ByteArray)
