package dev.ml2sensors.wire

import dev.ml2sensors.pacing.ImagePacing
import java.nio.ByteBuffer
import java.nio.channels.GatheringByteChannel

/**
 * Writes whole frames to a blocking channel; safe for use by several threads, frames never mix.
 *
 * @param pacing paces the frames that have a tail; null if nothing paces them.
 */
internal class FrameWriter(
    private val target: GatheringByteChannel,
    private val pacing: ImagePacing? = null,
    private val rosNowNanos: () -> Long,
) {
    private val pieces = arrayOfNulls<ByteBuffer>(2)
    private val together by lazy(LazyThreadSafetyMode.NONE) { ByteBuffer.allocateDirect(TOGETHER_BYTES) }

    /** Writes a control frame. */
    fun write(kind: FrameKind, body: ByteArray) {
        require(body.size <= kind.maxLength) { "$kind of ${body.size} bytes, at most ${kind.maxLength} are allowed" }
        val frame = ByteBuffer.allocate(FrameHeader.BYTES + body.size)
        FrameHeader(kind.code, body.size).writeTo(frame)
        write(frame.put(body).flip(), null)
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
            while (together.hasRemaining()) target.write(together)
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
        FrameHeader.patchSendNanos(head, head.position(), rosNowNanos())
        if (tail == null) {
            while (head.hasRemaining()) target.write(head)
            return
        }
        pieces[0] = head
        pieces[1] = tail
        if (pacing == null) writePieces(head, tail) else writePaced(pacing, head, tail)
        pieces.fill(null)
    }

    private fun writePieces(head: ByteBuffer, tail: ByteBuffer) {
        while (head.hasRemaining() || tail.hasRemaining()) target.write(pieces)
    }

    private fun writePaced(pacing: ImagePacing, head: ByteBuffer, tail: ByteBuffer) = pacing.image {
        val end = tail.limit()
        do {
            tail.limit(minOf(end, tail.position() + ImagePacing.SLICE_BYTES))
            val bytes = head.remaining() + tail.remaining()
            pacing.await(bytes)
            try {
                writePieces(head, tail)
            } finally {
                pacing.written(bytes)
            }
        } while (tail.position() < end)
    }

    companion object {
        /** The most that one record of TLS takes, RFC 8446, 5.1. */
        const val TOGETHER_BYTES: Int = 16 * 1024
    }
}
