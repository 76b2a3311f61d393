package dev.ml2sensors.pacing

import kotlin.math.max
import kotlin.math.min

/**
 * The rate at which the image lanes of a session may send together, so that the link has no queue in which a small
 * message waits. It knows what was acknowledged, the round trips of the time lane, and when images had to wait.
 *
 * - When two successive round trips have too much [QueueingDelay], or one that has not ended yet much too much, the link
 *   is congested.
 * - Then images first go at a quarter of what the link delivered, until its queue is empty.
 * - From a part of what it delivered the rate grows as [CubicGrowth], only while images wait for it. Above the rate at
 *   which the link was congested it grows slowly while images have pauses or the link has a queue, and not at all while
 *   the link delivers less than is sent.
 * - A link that does not answer for 200 ms stood still. Afterwards it has the rate that it had before.
 * - The bytes under way are bounded. So a link that becomes slower has no long queue.
 * - A delay that several cuts do not shorten has another cause, such as a longer route or another sender, and is taken
 *   for the path's own.
 *
 * Times are of one monotonic clock, in ns. Not thread-safe.
 */
internal class ImageRate(startNanos: Long) {
    /** A cut because of the round trip that began at [askedNanos], and the rate in B/s before. */
    private class Judgement(val askedNanos: Long, val bytesPerSecond: Double)

    /** Lanes tell it of their images. */
    val images: ImageActivity = ImageActivity(startNanos)
    private val delay = QueueingDelay()
    private val growth = GrowingRate(startNanos)
    private val sent = RecentBytes()
    private val delivered = RecentBytes()

    /** The cut that the round trip under way led to before its end; null if it led to none. */
    private var judgement: Judgement? = null
    private var congestion: Congestion? = null
    private var heldUntilNanos = startNanos

    /** The least round trip of the last 10 s; 0 before the first. */
    val leastRoundTripNanos: Long get() = delay.leastRoundTripNanos

    /** The bound of the rate that the user gave, in B/s. */
    var mostBytesPerSecond: Double = MOST

    /** True if images are smaller or fewer than the user wants. Then those that have pauses find a higher rate sooner. */
    var isMoreWanted: Boolean = false

    /** True while images wait because the rate of the link is not known yet. */
    fun isSearching(nowNanos: Long): Boolean =
        growth.congestedAt == null && images.areWaiting(nowNanos) && bytesPerSecond(nowNanos) < mostBytesPerSecond

    /** Returns the present rate in B/s. */
    fun bytesPerSecond(nowNanos: Long): Double {
        advance(nowNanos)
        return min(growth.bytesPerSecond(delay.leastRoundTripNanos, nowNanos), mostBytesPerSecond)
    }

    private fun advance(nowNanos: Long) = growth.advance(nowNanos) {
        when {
            !images.areWaiting(nowNanos) -> null
            !growth.isBeyond -> 1
            isBehind -> null
            delay.isLasting -> QUEUE_SLOWNESS
            !images.fillLink(nowNanos) -> if (isMoreWanted) SEARCH_SLOWNESS else PAUSES_SLOWNESS
            else -> 1
        }
    }

    /** True if bursts of images arrive more slowly than they are sent: at a higher rate they would only wait in the link. */
    private val isBehind get() = delivered.mostBytesPerSecond + ROUGHNESS < KEPT_UP * sent.mostBytesPerSecond

    /**
     * Returns how many bytes may be under way: what an empty path takes, and a queue that is long enough to be seen. A
     * link that becomes slower thus has no long queue before its round trips tell.
     */
    fun mostUnderWayBytes(nowNanos: Long): Double {
        val rate = bytesPerSecond(nowNanos)
        // Acknowledgements, too, wait on the way back
        val emptyPathNanos = delay.leastRoundTripNanos + delay.returningNanos
        return (rate * emptyPathNanos + growth.proven(rate) * (delay.toleratedNanos + SEEN_NANOS)) * 1e-9
    }

    /** Images wait at present because of the rate. */
    fun waited(nowNanos: Long) {
        advance(nowNanos)
        images.waited(nowNanos)
    }

    /** Since the session began, [sentBytes] were sent, and the receiver has acknowledged [bytes]. */
    fun acknowledged(bytes: Long, sentBytes: Long, nowNanos: Long) {
        sent.add(sentBytes, nowNanos)
        delivered.add(bytes, nowNanos)
    }

    /**
     * Adds a round trip of the time lane, which ended at [nowNanos].
     *
     * @param onPathNanos how much of it the path took; null if it does not tell of images.
     * @param thereNanos the time of its way to the receiver; off by a constant at most, null if it is not known.
     */
    fun roundTrip(nanos: Long, onPathNanos: Long?, thereNanos: Long?, nowNanos: Long) {
        val before = delay.lastNanos
        delay.addRoundTrip(nanos, thereNanos, nowNanos)
        if (onPathNanos == null) return
        val found = delay.behindImages(onPathNanos)
        val judgedRate = judgement?.bytesPerSecond
        judgement = null
        val isOnWayBack = found <= delay.toleratedNanos && delay.returningNanos > delay.toleratedNanos
        // The bytes under way alone cannot delay by STALL_NANOS, so the link stood still; or only the answer was late
        if (judgedRate != null && (isOnWayBack || found > STALL_NANOS)) return restart(judgedRate, null, nowNanos)
        if (!mayCut(nowNanos) || min(found, before) <= delay.toleratedNanos) return
        val grownDelay = found + max(0, found - before) // It has grown since this round trip began
        val deliveredRate = if (images.fillLink(nowNanos)) {
            delivered.bytesPerSecond(max(onPathNanos, MOMENTS_NANOS))
        } else {
            delivered.mostBytesPerSecond
        }
        congested(deliveredRate, grownDelay, nowNanos)
    }

    /**
     * The round trip that began at [askedNanos] has not ended yet. One that is much too long tells of a queue that fills
     * quickly, before small messages are lost in it.
     */
    fun unanswered(askedNanos: Long, nowNanos: Long) {
        val waiting = nowNanos - askedNanos - delay.leastRoundTripNanos - delay.returningNanos
        val isCertain = waiting > CERTAIN * delay.toleratedNanos && images.fillLink(nowNanos)
        if (askedNanos == judgement?.askedNanos || !isCertain || !mayCut(nowNanos)) return
        judgement = Judgement(askedNanos, bytesPerSecond(nowNanos))
        congested(delivered.bytesPerSecond(nowNanos - askedNanos), waiting, nowNanos)
    }

    private fun mayCut(nowNanos: Long) = nowNanos >= heldUntilNanos && images.areWritten(nowNanos)

    private fun congested(deliveredRate: Double, delayNanos: Long, nowNanos: Long) {
        val isFilled = images.fillLink(nowNanos)
        val isRelated = nowNanos - heldUntilNanos < RELATED_NANOS + 2 * delay.leastRoundTripNanos
        val before = congestion?.takeIf { isRelated && (it.isMeasured || !isFilled) }
        val drainedNanos = nowNanos + DRAIN_DELAYS * delayNanos
        if (before == null) {
            val rate = growth.cut(bytesPerSecond(nowNanos), deliveredRate, isFilled)
            restart(rate, Congestion(rate, delayNanos, isFilled), drainedNanos)
        } else if (before.isElsewhere(delayNanos)) {
            delay.accept(delayNanos, nowNanos)
            restart(before.bytesPerSecond, null, drainedNanos)
        } else {
            val rate = before.furtherRate(deliveredRate.takeIf { isFilled })
            restart(rate, before.further(delayNanos), drainedNanos)
        }
    }

    private fun restart(bytesPerSecond: Double, congestion: Congestion?, drainedNanos: Long) {
        growth.restart(bytesPerSecond, drainedNanos)
        this.congestion = congestion
        // A round trip that is under way has seen the queue, the next one has not
        heldUntilNanos = drainedNanos + 2 * delay.leastRoundTripNanos + SHORTEST_HOLD_NANOS
        delay.restart()
    }

    companion object {
        /** More than any link has, in B/s. */
        const val MOST: Double = 10e9 / 8

        /** No answer for so long means that the link stands still. */
        const val STALL_NANOS: Long = 200_000_000L

        /** So many times the tolerated delay needs no second round trip. */
        private const val CERTAIN = 3
        private const val SEEN_NANOS = 2_000_000L
        private const val MOMENTS_NANOS = 40_000_000L

        /** So many times the delay drains the queue of a link that small messages fill to a third. */
        private const val DRAIN_DELAYS = 2

        /** By which factor the rate grows more slowly when a queue tells that the link has no more. */
        private const val QUEUE_SLOWNESS = 25

        /** The same while images have pauses, and so have what they need. */
        private const val PAUSES_SLOWNESS = 25

        /** The same if more is wanted. Measured: 20 Mbit/s that became 100 are found in 5 s. */
        private const val SEARCH_SLOWNESS = 5

        /** A link keeps up if it delivers this part. */
        private const val KEPT_UP = 0.9

        /** A slice of 16 KiB in 20 ms, in B/s: images are sent in slices, so the counts are no finer. */
        private const val ROUGHNESS = 0.8e6
        private const val SHORTEST_HOLD_NANOS = 40_000_000L

        /** Congestion so soon after a cut is the same one. */
        private const val RELATED_NANOS = 300_000_000L
    }
}
