package dev.ml2sensors.clock

import kotlin.math.abs

/**
 * Estimates offset (host minus device) and skew from time exchanges, with [OffsetFit]. Keeps the tightest bounds of
 * each of the last [MAX_SPANS] half seconds with exchanges, over all sessions: a bound stays true and only loosens
 * with age. Exchanges that contradict the estimate are set aside; [STEP_RUN] of them within a second start a new fit.
 * Does no I/O; used by one thread.
 */
internal class OffsetEstimator {
    private val bounds = ArrayDeque<TightestBounds>()
    private val contradicting = ArrayDeque<TimeExchange>()
    private var latest: OffsetEstimate? = null

    /** The number of jumps of the host's clock by more than [STEP_NANOS]. */
    var steps = 0L
        private set

    /** Adds one exchange and returns the estimate at its end. */
    fun add(exchange: TimeExchange): OffsetEstimate {
        val known = latest
        val next = if (known != null &&
            known.isContradictedBy(exchange)
        ) {
            addContradicting(known, exchange)
        } else {
            addConsistent(exchange)
        }
        latest = next
        return next
    }

    private fun addConsistent(exchange: TimeExchange): OffsetEstimate {
        addBounds(exchange)
        return OffsetFit(bounds, exchange.t4).fit(likelySkewPpb = latest?.skewPpb ?: 0)
    }

    private fun addContradicting(known: OffsetEstimate, exchange: TimeExchange): OffsetEstimate {
        contradicting.removeIf { exchange.t4 - it.t4 > RUN_NANOS }
        contradicting += exchange
        if (contradicting.size < STEP_RUN) return known
        bounds.clear()
        contradicting.forEach(::addBounds)
        contradicting.clear()
        val next = addConsistent(exchange)
        if (abs(next.offsetNanos - known.offsetNanos(next.atNanos)) > STEP_NANOS) steps++
        return next
    }

    private fun addBounds(exchange: TimeExchange) {
        val current = bounds.lastOrNull()
        if (current != null && exchange.t4 - current.beganNanos < SPAN_NANOS) {
            current.tighten(exchange, latest?.skewPpb ?: 0)
            return
        }
        bounds += TightestBounds(exchange)
        if (bounds.size > MAX_SPANS) bounds.removeFirst()
    }

    companion object {
        /** A larger error counts as a step; [StampMap] slews a smaller one away within ten seconds. */
        const val STEP_NANOS: Long = 5_000_000
        private const val RUN_NANOS = 1_000_000_000L
        private const val SPAN_NANOS = 500_000_000L
        private const val MAX_SPANS = 30

        /** One would suffice, since the bounds are hard. But a step costs stamps, and three arrive within 0.15 s. */
        private const val STEP_RUN = 3
    }
}

/** The tightest upper and lower bound and the least round trip of half a second of exchanges. */
internal class TightestBounds(first: TimeExchange) {
    val beganNanos: Long = first.t4
    var above: TimeExchange = first
        private set
    var below: TimeExchange = first
        private set
    var roundTripNanos: Long = first.roundTripNanos
        private set

    fun tighten(exchange: TimeExchange, skewPpb: Long) {
        fun grown(nanos: Long): Long = (nanos * 1e-9 * skewPpb).toLong()
        val most = exchange.mostOffsetNanos - above.mostOffsetNanos
        if (most <= grown(exchange.t1 - above.t1)) above = exchange
        val least = exchange.leastOffsetNanos - below.leastOffsetNanos
        if (least >= grown(exchange.t4 - below.t4)) below = exchange
        roundTripNanos = minOf(roundTripNanos, exchange.roundTripNanos)
    }
}

/**
 * The four times of one exchange: [t1] and [t4] on the device's clock, t2 and t3 in the host's ROS time, all ns.
 *
 * Nothing arrives before it is sent, so t1 + offset <= t2 and t3 <= t4 + offset: two bounds that hold whatever the path
 * does.
 */
internal class TimeExchange(val t1: Long, t2: Long, t3: Long, val t4: Long) {
    /** Host minus device at [t1] is at most this. */
    val mostOffsetNanos: Long = t2 - t1

    /** Host minus device at [t4] is at least this. */
    val leastOffsetNanos: Long = t3 - t4

    val roundTripNanos: Long get() = mostOffsetNanos - leastOffsetNanos
}
