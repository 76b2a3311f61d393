package dev.ml2sensors.wire

import dev.ml2sensors.pacing.ImagePacing
import java.nio.ByteBuffer
import java.nio.channels.GatheringByteChannel

/**
 * Writes whole frames to a blocking channel; safe for use by several threads, frames never mix.
 *
 * @param pacing paces the frames of a lane, but not control frames; null if nothing paces them.
 */
internal class FrameWriter(
    private val target: GatheringByteChannel,
    private val pacing: ImagePacing? = null,
    private val rosNowNanos: () -> Long,
) {
    private val pieces = arrayOfNulls<ByteBuffer>(2)
    private val together by lazy(LazyThreadSafetyMode.NONE) { ByteBuffer.allocateDirect(TOGETHER_BYTES) }

    /** Writes a small frame; [channel] and [sequence] are those of an opening. */
    fun write(kind: FrameKind, body: ByteArray, channel: Int = 0, sequence: Int = 0, captureNanos: Long = 0) {
        require(body.size <= kind.maxLength) { "$kind of ${body.size} bytes, at most ${kind.maxLength} are allowed" }
        val frame = ByteBuffer.allocate(FrameHeader.BYTES + body.size)
        FrameHeader(kind.code, body.size, channel, sequence, captureNanos).writeTo(frame)
        writeWhole(frame.put(body).flip())
    }

    @Synchronized
    private fun writeWhole(frame: ByteBuffer) {
        FrameHeader.patchSendNanos(frame, frame.position(), rosNowNanos())
        while (frame.hasRemaining()) target.write(frame)
    }

    /**
     * Writes [frames] of at most [TOGETHER_BYTES] with one call, so that many small ones cost the kernel, TLS and the
     * receiver as much as one. Calls [written] for each frame that was handed over whole, also when it fails.
     */
    @Synchronized
    fun writeTogether(frames: List<ByteBuffer>, written: () -> Unit) {
        val now = rosNowNanos()
        together.clear()
        val ends = IntArray(frames.size) {
            FrameHeader.patchSendNanos(frames[it], frames[it].position(), now)
            together.put(frames[it]).position()
        }
        together.flip()
        try {
            if (pacing == null) {
                writeTogether()
            } else {
                pacing.image { pacing.slice(together.remaining()) { writeTogether() } }
            }
        } finally {
            for (end in ends) if (end <= together.position()) written()
        }
    }

    /**
     * Writes a frame whose header and first bytes stand in [head] and whose remaining body is [tail], both from position
     * to limit, by gathering writes; returns when the last byte is handed to the kernel.
     */
    @Synchronized
    fun write(head: ByteBuffer, tail: ByteBuffer?) {
        if (tail == null && pacing == null) return writeWhole(head)
        FrameHeader.patchSendNanos(head, head.position(), rosNowNanos())
        val rest = tail ?: NOTHING
        pieces[0] = head
        pieces[1] = rest
        if (pacing == null) writePieces(head, rest) else writePaced(pacing, head, rest)
        pieces.fill(null)
    }

    private fun writeTogether() {
        while (together.hasRemaining()) target.write(together)
    }

    private fun writePieces(head: ByteBuffer, tail: ByteBuffer) {
        while (head.hasRemaining() || tail.hasRemaining()) target.write(pieces)
    }

    private fun writePaced(pacing: ImagePacing, head: ByteBuffer, tail: ByteBuffer) = pacing.image {
        val headEnd = head.limit()
        val tailEnd = tail.limit()
        do {
            head.limit(minOf(headEnd, head.position() + ImagePacing.SLICE_BYTES))
            val tailBytes = if (head.limit() < headEnd) 0 else ImagePacing.SLICE_BYTES
            tail.limit(minOf(tailEnd, tail.position() + tailBytes))
            pacing.slice(head.remaining() + tail.remaining()) { writePieces(head, tail) }
        } while (head.position() < headEnd || tail.position() < tailEnd)
    }

    companion object {
        /** The most that one record of TLS takes, RFC 8446, 5.1. */
        const val TOGETHER_BYTES: Int = 16 * 1024
        private val NOTHING: ByteBuffer = ByteBuffer.allocateDirect(0)
    }
}
