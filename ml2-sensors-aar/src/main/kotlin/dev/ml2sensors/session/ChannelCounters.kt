package dev.ml2sensors.session

import dev.ml2sensors.source.DropReason
import dev.ml2sensors.wire.Status
import java.util.concurrent.atomic.AtomicLong
import java.util.concurrent.atomic.AtomicLongArray

/**
 * The books of one channel over the life of the app instance: produced = sent + dropped + queued. Sequence numbers are
 * given here, so a message that is dropped later leaves a gap. Safe for use by several threads.
 */
internal class ChannelCounters {
    private val produced = AtomicLong()
    private val sent = AtomicLong()
    private val dropped = AtomicLongArray(DropReason.entries.size)

    /** Enters one message that is produced; its sequence number, modulo 2^32. */
    fun nextSequence(): Int = produced.getAndIncrement().toInt()

    fun countSent() {
        sent.incrementAndGet()
    }

    fun countDropped(reason: DropReason) {
        dropped.incrementAndGet(reason.ordinal)
    }

    /** Enters [count] messages that a source could not deliver. */
    fun countLost(count: Int, reason: DropReason) {
        produced.addAndGet(count.toLong())
        dropped.addAndGet(reason.ordinal, count.toLong())
    }

    /**
     * Between two sessions: [received] arrived. Others that were sent went down with the link, and some that were under
     * way when it broke did arrive.
     */
    fun reconcile(received: Long) {
        val missing = (sent.get() - received).coerceAtLeast(-dropped.get(DropReason.LINK_DOWN.ordinal))
        sent.addAndGet(-missing)
        dropped.addAndGet(DropReason.LINK_DOWN.ordinal, missing)
    }

    fun snapshot(): Status.ChannelCounts {
        val byReason = DropReason.entries.associate { it.wireName to dropped.get(it.ordinal) }.filterValues { it > 0 }
        return Status.ChannelCounts(produced.get(), sent.get(), byReason)
    }
}
