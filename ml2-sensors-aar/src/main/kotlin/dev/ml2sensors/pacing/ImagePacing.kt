package dev.ml2sensors.pacing

import java.util.concurrent.CopyOnWriteArrayList
import java.util.concurrent.locks.LockSupport
import java.util.concurrent.locks.ReentrantLock

/**
 * Paces those lanes of one session whose class is paced, at a common [ImageRate], in turns of [SLICE_BYTES]. Thread-safe;
 * lanes wait in [await], on threads that may block.
 *
 * @param isUrgentBlocked returns true while small messages wait for the network: images let them pass.
 */
internal class ImagePacing(
    private val nanoTime: () -> Long = System::nanoTime,
    private val park: (nanos: Long) -> Unit = LockSupport::parkNanos,
    private val isUrgentBlocked: () -> Boolean,
) {
    private val rate = ImageRate(nanoTime())

    /** The lane that holds this lock writes. Lanes get it in the order in which they asked. */
    private val turn = ReentrantLock(true)
    private var nextNanos = nanoTime()
    private val unacknowledged = CopyOnWriteArrayList<() -> Int>()

    @Volatile
    private var isOver = false

    /** The round trip that is under way; null while there is none. */
    @Volatile
    private var roundTrip: RoundTrip? = null

    private var writtenBytes = 0L

    /** The bytes of slices that may be written, and were not yet. */
    private var grantedBytes = 0L
    private var writers = 0

    /** The least round trip of the last 10 s; 0 before the first. */
    val leastRoundTripNanos: Long get() = synchronized(rate) { rate.leastRoundTripNanos }

    /** Adds a paced lane; [bytes] returns how many bytes of it the receiver has not acknowledged, until [remove]. */
    fun add(bytes: () -> Int) {
        unacknowledged += bytes
    }

    fun remove(bytes: () -> Int) {
        unacknowledged -= bytes
    }

    /** Calls [write], which writes one image in slices, each of them by [slice]. */
    inline fun image(write: () -> Unit) {
        begin()
        try {
            write()
        } finally {
            finish()
        }
    }

    /** Waits until [bytes] of an image may be written, and calls [write], which writes them. */
    inline fun slice(bytes: Int, write: () -> Unit) {
        await(bytes)
        try {
            write()
        } finally {
            written(bytes)
        }
    }

    private fun begin(): Unit = synchronized(rate) { if (writers++ == 0) rate.images.resume(nanoTime()) }

    private fun finish(): Unit = synchronized(rate) { if (--writers == 0) rate.images.pause(nanoTime()) }

    /**
     * Waits until [bytes] of an image may be written. Call [written] afterwards.
     *
     * @throws InterruptedException when the thread is interrupted.
     */
    fun await(bytes: Int) {
        turn.lockInterruptibly()
        try {
            var waitNanos = waitNanos()
            while (waitNanos > 0) {
                park(minOf(waitNanos, LONGEST_PARK_NANOS))
                if (Thread.interrupted()) throw InterruptedException()
                waitNanos = waitNanos()
            }
            val now = nanoTime()
            val bytesPerSecond = synchronized(rate) {
                grantedBytes += bytes
                rate.bytesPerSecond(now)
            }
            nextNanos = maxOf(nextNanos, now - BURST_NANOS) + (bytes * NANOS_PER_SECOND / bytesPerSecond).toLong()
        } finally {
            turn.unlock()
        }
    }

    /** Paces nothing any more: what is left of a session is sent at once. */
    fun end() {
        isOver = true
    }

    private fun waitNanos(): Long {
        if (isOver) return 0
        val now = nanoTime()
        val untilTurn = nextNanos - now
        val underWayBytes = underWayBytes()
        val isLinkFull = synchronized(rate) {
            acknowledged(underWayBytes, now)
            val roundTrip = roundTrip
            if (roundTrip != null && roundTrip.isBehindImages) rate.unanswered(roundTrip.startNanos, now)
            if (untilTurn > 0) rate.waited(now)
            grantedBytes + underWayBytes > maxOf(SLICE_BYTES.toDouble(), rate.mostUnderWayBytes(now))
        }
        if (untilTurn > 0) return untilTurn
        val isHeld = isStalled(now) || isUrgentBlocked() || isLinkFull
        return if (isHeld && untilTurn > -LONGEST_HOLD_NANOS) HOLD_POLL_NANOS else 0
    }

    private fun underWayBytes() = unacknowledged.sumOf { it() }

    private fun acknowledged(underWayBytes: Int, nowNanos: Long) {
        rate.acknowledged(writtenBytes - underWayBytes, writtenBytes, nowNanos)
        if (knowsUnderWay) roundTrip?.acknowledged(writtenBytes - underWayBytes, nowNanos)
    }

    /** False if no kernel tells what it holds of a lane. */
    private val knowsUnderWay get() = unacknowledged.isNotEmpty()

    private fun isStalled(nowNanos: Long) =
        roundTrip.let { it != null && nowNanos - it.startNanos > ImageRate.STALL_NANOS }

    /** The [bytes] of [await] were handed to the kernel, or their lane was lost. */
    fun written(bytes: Int): Unit = synchronized(rate) {
        grantedBytes -= bytes
        writtenBytes += bytes
        rate.images.written(nanoTime())
    }

    /** Bounds the rate; null means that only the link does. */
    fun limit(bytesPerSecond: Double?): Unit = synchronized(rate) {
        rate.mostBytesPerSecond = bytesPerSecond ?: ImageRate.MOST
    }

    /** Tells whether images are smaller or fewer than the user wants. */
    fun wantMore(isMoreWanted: Boolean): Unit = synchronized(rate) { rate.isMoreWanted = isMoreWanted }

    /** Returns what is known of the link; the arguments are as in [LinkState]. */
    fun linkState(waitingSinceNanos: Long?, droppedImages: Long): LinkState = synchronized(rate) {
        val now = nanoTime()
        val isUnsettled = isStalled(now) || rate.isSearching(now)
        LinkState(waitingSinceNanos, isUnsettled, droppedImages, writtenBytes, rate.bytesPerSecond(now))
    }

    /**
     * Measures the round trip of [exchange]; called by one thread.
     *
     * @param thereNanos returns from its result the time of the way to the receiver, as in [ImageRate.roundTrip].
     */
    inline fun <T> measured(exchange: () -> T, thereNanos: (T) -> Long?): T {
        ask()
        try {
            return exchange().also { answered(thereNanos(it)) }
        } finally {
            roundTrip = null
        }
    }

    private fun ask() {
        val underWayBytes = underWayBytes()
        synchronized(rate) {
            val acknowledgedBytes = if (knowsUnderWay) writtenBytes - underWayBytes else null
            roundTrip = RoundTrip(nanoTime(), writtenBytes, acknowledgedBytes)
        }
    }

    private fun answered(thereNanos: Long?) {
        val underWayBytes = underWayBytes()
        synchronized(rate) {
            val now = nanoTime()
            acknowledged(underWayBytes, now)
            val roundTrip = checkNotNull(roundTrip)
            val nanos = now - roundTrip.startNanos
            rate.roundTrip(nanos, roundTrip.onPathNanos(now), thereNanos, now)
        }
    }

    companion object {
        /** One record of TLS. */
        const val SLICE_BYTES: Int = 16 * 1024
        private const val NANOS_PER_SECOND = 1e9

        /** After a pause, a lane may write at once what the rate allows in this time. */
        private const val BURST_NANOS = 1_000_000L
        private const val LONGEST_PARK_NANOS = 5_000_000L
        private const val HOLD_POLL_NANOS = 500_000L

        /** A slice may go so often in any case: a link that small messages fill shows a picture now and then. */
        private const val LONGEST_HOLD_NANOS = 250_000_000L
    }
}
