package dev.ml2sensors.session

import dev.ml2sensors.source.DropReason
import dev.ml2sensors.table.LaneClass
import dev.ml2sensors.wire.FrameWriter
import kotlinx.coroutines.CancellationException
import kotlinx.coroutines.channels.Channel
import kotlinx.coroutines.flow.MutableStateFlow
import kotlinx.coroutines.flow.first
import java.util.concurrent.atomic.AtomicLong

/**
 * A bounded queue of frames that are sent in order over a connection of their own. It outlives connections: each
 * session passes one to [sendThrough].
 *
 * When the queue is full, the oldest frame that is not being written is dropped. With [suspendsWhenFull], for
 * recordings, producers are suspended instead, also while there is no session. Safe for use by several producers.
 */
internal class Lane(val name: String, val spec: LaneClass, private val suspendsWhenFull: Boolean) {
    private val hasSession = MutableStateFlow(false)

    /** The beginning of the write that is under way, by System.nanoTime(); 0 while there is none. */
    @Volatile
    private var writingSinceNanos = 0L

    /** The time since which there has always been a frame to send, by System.nanoTime(); null while there is none. */
    @Volatile
    var waitingSinceNanos: Long? = null
        private set

    /** The number of frames that were dropped, or not even made, because the queue was full. */
    val overflows: Long get() = overflowCount.get()
    private val overflowCount = AtomicLong()

    /** True while frames are taken; without a session they are dropped. */
    val isOpen: Boolean get() = hasSession.value

    /** True while the network takes nothing more for now. */
    val isBlocked: Boolean
        get() = writingSinceNanos.let { it != 0L && System.nanoTime() - it > BLOCKED_NANOS }

    private val queue =
        Channel<OutgoingFrame>(spec.queueFrames, onUndeliveredElement = { it.drop(DropReason.LINK_DOWN) })

    /** Takes over [frame], which is sent or dropped, and counted. */
    suspend fun offer(frame: OutgoingFrame) {
        if (suspendsWhenFull) awaitSessionFor(frame)
        offerIfInSession(frame)
    }

    /** As [offer], but drops the frame if there is no session. */
    suspend fun offerIfInSession(frame: OutgoingFrame): Unit =
        ifInSession(frame) { if (suspendsWhenFull) queue.send(frame) else enqueue(frame) }

    /** As [offer], but never waits. */
    fun offerNow(frame: OutgoingFrame): Unit = ifInSession(frame) { enqueue(frame) }

    private inline fun ifInSession(frame: OutgoingFrame, enqueue: () -> Unit) {
        if (!hasSession.value) return frame.drop(DropReason.LINK_DOWN)
        try {
            enqueue()
        } finally {
            // The session may have ended since the check, and with it the reader of the queue
            if (!hasSession.value) dropQueued()
        }
    }

    /** Counts a frame that was not made because the queue was full. */
    fun countUnmade() {
        overflowCount.incrementAndGet()
    }

    private fun enqueue(frame: OutgoingFrame) {
        while (true) {
            val result = queue.trySend(frame)
            when {
                result.isSuccess -> return

                result.isClosed -> return frame.drop(DropReason.LINK_DOWN)

                else -> queue.tryReceive().getOrNull()?.let {
                    overflowCount.incrementAndGet()
                    it.drop(DropReason.QUEUE_FULL)
                }
            }
        }
    }

    private suspend fun awaitSessionFor(frame: OutgoingFrame) {
        try {
            awaitSession()
        } catch (e: CancellationException) {
            frame.drop(DropReason.LINK_DOWN)
            throw e
        }
    }

    /** Waits until [sendThrough] has begun. */
    suspend fun awaitSession() {
        hasSession.first { it }
    }

    /**
     * Sends queued frames through [writer] until the lane is finished; fails when the connection does. Frames without
     * pixels that wait behind each other are written together.
     */
    suspend fun sendThrough(writer: FrameWriter) {
        hasSession.value = true
        val batch = ArrayList<OutgoingFrame>()
        var next: OutgoingFrame? = null
        try {
            while (true) {
                batch += next ?: receive() ?: return
                next = fill(batch)
                write(batch, writer)
            }
        } finally {
            hasSession.value = false
            waitingSinceNanos = null
            next?.drop(DropReason.LINK_DOWN)
            dropQueued()
        }
    }

    /** Waits for the next frame; returns null when the lane is finished. */
    private suspend fun receive(): OutgoingFrame? {
        queue.tryReceive().getOrNull()?.let { return it }
        waitingSinceNanos = null
        return queue.receiveCatching().getOrNull()?.also { waitingSinceNanos = System.nanoTime() }
    }

    /** Adds the waiting frames that can be written together with the one in [batch]; returns the first that cannot. */
    private fun fill(batch: MutableList<OutgoingFrame>): OutgoingFrame? {
        val first = batch.single()
        if (first.data != null) return null
        var bytes = first.head.remaining()
        while (true) {
            val next = queue.tryReceive().getOrNull() ?: return null
            bytes += next.head.remaining()
            if (next.data != null || bytes > FrameWriter.TOGETHER_BYTES) return next
            batch += next
        }
    }

    /** Writes the frames of [batch], counts each as sent or dropped, and empties it. */
    private suspend fun write(batch: MutableList<OutgoingFrame>, writer: FrameWriter) {
        var sent = 0
        try {
            writingSinceNanos = System.nanoTime()
            blockingIo {
                if (batch.size == 1) {
                    writer.write(batch[0].head, batch[0].data)
                    sent++
                } else {
                    writer.writeTogether(batch.map { it.head }) { sent++ }
                }
            }
        } finally {
            writingSinceNanos = 0
            batch.forEachIndexed { i, frame -> if (i < sent) frame.sent() else frame.drop(DropReason.LINK_DOWN) }
            batch.clear()
        }
    }

    /** Takes no more frames: [sendThrough] returns when the queue is empty. */
    fun finish() {
        queue.close()
    }

    /** Drops the queued frames. */
    fun dropQueued() {
        while (true) (queue.tryReceive().getOrNull() ?: return).drop(DropReason.LINK_DOWN)
    }

    private companion object {
        const val BLOCKED_NANOS = 10_000_000L
    }
}
