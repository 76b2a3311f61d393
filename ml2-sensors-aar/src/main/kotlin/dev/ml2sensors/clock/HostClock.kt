package dev.ml2sensors.clock

import dev.ml2sensors.source.DeviceClock
import kotlinx.coroutines.flow.MutableStateFlow
import kotlinx.coroutines.flow.first
import kotlinx.coroutines.withTimeoutOrNull

/**
 * The device's estimate of the host's clock over all sessions. It takes time exchanges, steers the [stamps] map and
 * reports its state. Thread-safe.
 */
internal class HostClock(private val deviceClock: DeviceClock) {
    val stamps: StampMap = StampMap(deviceClock)
    private val estimator = OffsetEstimator()
    private val estimate = MutableStateFlow<OffsetEstimate?>(null)
    private var exchanges = 0
    private var lastExchangeNanos = Long.MIN_VALUE / 2
    private var nextSteerNanos = Long.MIN_VALUE
    private var frozen = false

    enum class State(val wireName: String) {
        /** No estimate yet. */
        WAITING("waiting"),

        SYNCHRONISED("synchronised"),

        /** No exchange for [HOLDOVER_AFTER_NANOS], or no session: the last estimate is extrapolated. */
        HOLDOVER("holdover"),

        /** A recording is stamped with a constant offset. */
        FROZEN("frozen"),
    }

    /**
     * The state and the estimate at present; zeros before there is an estimate.
     *
     * @property uncertaintyNanos of stamps made now: the uncertainty of the estimate plus what the map still has to
     * slew.
     * @property steps how often the host's clock has jumped.
     */
    class Status(
        val state: State,
        val offsetNanos: Long,
        val uncertaintyNanos: Long,
        val roundTripNanos: Long,
        val skewPpm: Double,
        val steps: Long,
        val epoch: Long,
    )

    val status: Status
        @Synchronized get() {
            val now = deviceClock.nowNanos()
            val known = estimate.value ?: return Status(state(now), 0, 0, 0, 0.0, estimator.steps, stamps.epoch)
            val offset = known.offsetNanos(now)
            val slewing = if (frozen) 0 else stamps.errorNanos(offset, now)
            return Status(
                state(now),
                offset,
                known.uncertaintyNanos(now) + slewing,
                known.roundTripNanos,
                known.skewPpb / PPB_PER_PPM,
                estimator.steps,
                stamps.epoch,
            )
        }

    private fun state(now: Long): State = when {
        frozen -> State.FROZEN
        estimate.value == null -> State.WAITING
        now - lastExchangeNanos > HOLDOVER_AFTER_NANOS -> State.HOLDOVER
        else -> State.SYNCHRONISED
    }

    /** Holds the last estimate until the next exchange. */
    @Synchronized
    fun endSession() {
        lastExchangeNanos = Long.MIN_VALUE / 2
    }

    @Synchronized
    fun add(exchange: TimeExchange) {
        val steps = estimator.steps
        val latest = estimator.add(exchange)
        lastExchangeNanos = exchange.t4
        if (++exchanges < FIRST_EXCHANGES) return
        if (exchange.t4 >= nextSteerNanos || estimator.steps > steps) {
            stamps.steerTo(latest.offsetNanos(exchange.t4), exchange.t4, latest.skewPpb)
            nextSteerNanos = exchange.t4 + STEER_INTERVAL_NANOS
        }
        estimate.value = latest
    }

    /**
     * Waits until stamps can be made: for a good first estimate, but at most [FIRST_ESTIMATE_LIMIT_MILLIS]; then the
     * device's own wall clock serves, and the state stays waiting until there is an estimate.
     */
    suspend fun awaitStamps() {
        if (stamps.isSet) return
        withTimeoutOrNull(FIRST_ESTIMATE_LIMIT_MILLIS) { estimate.first { it != null } }
        setFromWallClock()
    }

    @Synchronized
    private fun setFromWallClock() {
        if (stamps.isSet) return
        val nowNanos = deviceClock.nowNanos()
        stamps.steerTo(System.currentTimeMillis() * NANOS_PER_MILLI - nowNanos, nowNanos)
    }

    /** Fixes the map at its present offset permanently. */
    @Synchronized
    fun freeze() {
        if (frozen) return
        stamps.freeze(deviceClock.nowNanos())
        frozen = true
    }

    /**
     * Returns how long the request of [exchange] took to the host, in ns. It is off by a constant, since an asymmetry of
     * the path cannot be seen, and by less than [MOST_UNSURE_NANOS]; null where that is not certain.
     */
    fun thereNanos(exchange: TimeExchange): Long? = estimate.value
        ?.takeIf { it.uncertaintyNanos(exchange.t1) - it.roundTripNanos / 2 < MOST_UNSURE_NANOS }
        ?.let { exchange.mostOffsetNanos - it.offsetNanos(exchange.t1) }

    /** Returns the present ROS time by the latest estimate, or 0 before there is one. */
    fun rosNowNanos(): Long {
        val now = deviceClock.nowNanos()
        return estimate.value?.let { now + it.offsetNanos(now) } ?: 0
    }

    private companion object {
        /** An eighth of the first burst: the least round trip of so many is within jitter of the best on a quiet link. */
        const val FIRST_EXCHANGES = 16
        const val STEER_INTERVAL_NANOS = 250_000_000L

        /** Twice the longest stall that a healthy wireless link has. */
        const val HOLDOVER_AFTER_NANOS = 1_000_000_000L

        /** A third of the queue of images that the pacing tolerates. */
        const val MOST_UNSURE_NANOS = 2_000_000L
        const val FIRST_ESTIMATE_LIMIT_MILLIS = 5_000L
        const val NANOS_PER_MILLI = 1_000_000L
        const val PPB_PER_PPM = 1_000.0
    }
}
