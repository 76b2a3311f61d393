package dev.ml2sensors.session

import dev.ml2sensors.source.DropReason
import dev.ml2sensors.wire.Status
import java.util.concurrent.atomic.AtomicLong
import java.util.concurrent.atomic.AtomicLongArray

/**
 * The counters of one channel over the life of the app instance: produced = sent + dropped + queued. Sequence numbers
 * are given here, so a message that is dropped later leaves a gap. Thread-safe.
 */
internal class ChannelCounters {
    private val produced = AtomicLong()
    private val sent = AtomicLong()
    private val dropped = AtomicLongArray(DropReason.entries.size)
    private val discardedCount = AtomicLong()

    /** The number of messages that were made and then dropped. */
    val discarded: Long get() = discardedCount.get()

    /** Counts one produced message and returns its sequence number, modulo 2^32. */
    fun nextSequence(): Int = produced.getAndIncrement().toInt()

    fun countSent() {
        sent.incrementAndGet()
    }

    fun countDropped(reason: DropReason) {
        dropped.incrementAndGet(reason.ordinal)
        discardedCount.incrementAndGet()
    }

    /** Counts [count] messages that a source could not deliver. */
    fun countLost(count: Int, reason: DropReason) {
        produced.addAndGet(count.toLong())
        dropped.addAndGet(reason.ordinal, count.toLong())
    }

    /**
     * Corrects the counters between two sessions, when the receiver reports that [received] messages arrived: some that
     * were sent are lost, and some that were counted as lost may have arrived.
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
