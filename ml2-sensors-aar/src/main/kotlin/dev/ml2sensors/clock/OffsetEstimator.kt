package dev.ml2sensors.clock

import kotlin.math.abs

/**
 * Host-minus-device offset and skew from time exchanges, by [OffsetFit]. Keeps the tightest bounds of each of the last
 * [KEPT_SPANS] half seconds in which there were exchanges, on whatever link: a bound stays true, it only loosens with
 * age. Exchanges that no clock of a steady rate can explain are set aside; [STEP_RUN] of them within a second begin a new
 * fit. Does no I/O; used by one thread.
 */
internal class OffsetEstimator {
    private val bounds = ArrayDeque<TightestBounds>()
    private val contradicting = ArrayDeque<TimeExchange>()
    private var latest: OffsetEstimate? = null

    /** How often the host's clock jumped by more than [STEP_NANOS]. */
    var steps = 0L
        private set

    /** Takes in one exchange and gives the estimate as of its end. */
    fun add(exchange: TimeExchange): OffsetEstimate {
        val known = latest
        val next = if (known != null && known.isContradictedBy(exchange)) doubt(known, exchange) else follow(exchange)
        latest = next
        return next
    }

    private fun follow(exchange: TimeExchange): OffsetEstimate {
        keep(exchange)
        return OffsetFit(bounds, exchange.t4).fit(likelySkewPpb = latest?.skewPpb ?: 0)
    }

    private fun doubt(known: OffsetEstimate, exchange: TimeExchange): OffsetEstimate {
        contradicting.removeIf { exchange.t4 - it.t4 > RUN_NANOS }
        contradicting += exchange
        if (contradicting.size < STEP_RUN) return known
        bounds.clear()
        contradicting.forEach(::keep)
        contradicting.clear()
        val next = follow(exchange)
        if (abs(next.offsetNanos - known.offsetNanos(next.atNanos)) > STEP_NANOS) steps++
        return next
    }

    private fun keep(exchange: TimeExchange) {
        val current = bounds.lastOrNull()
        if (current != null && exchange.t4 - current.beganNanos < SPAN_NANOS) {
            current.tighten(exchange, latest?.skewPpb ?: 0)
            return
        }
        bounds += TightestBounds(exchange)
        if (bounds.size > KEPT_SPANS) bounds.removeFirst()
    }

    companion object {
        /** What is not slewed away within ten seconds by [StampMap] counts as a step. */
        const val STEP_NANOS: Long = 5_000_000
        private const val RUN_NANOS = 1_000_000_000L
        private const val SPAN_NANOS = 500_000_000L
        private const val KEPT_SPANS = 30

        /** One would do, as the bounds are hard; but a step costs stamps, and three come within 0.15 s. */
        private const val STEP_RUN = 3
    }
}

/** Of the exchanges of half a second, the two that say most, and the least round trip. */
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
