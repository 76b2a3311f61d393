package dev.ml2sensors.clock

import dev.ml2sensors.source.DeviceClock
import kotlinx.coroutines.flow.MutableStateFlow
import kotlinx.coroutines.flow.first
import kotlinx.coroutines.withTimeoutOrNull

/**
 * What the device knows of the host's clock over all sessions: takes exchanges in, keeps the [stamps] map steered, and
 * tells its state. Safe for use by several threads.
 */
internal class HostClock(private val deviceClock: DeviceClock) {
    val stamps: StampMap = StampMap()
    private var estimator = OffsetEstimator()
    private var exchanges = 0
    private var nextSteerNanos = Long.MIN_VALUE
    private val estimate = MutableStateFlow<OffsetEstimate?>(null)
    private val state = MutableStateFlow(State.WAITING)

    enum class State(val wireName: String) {
        WAITING("waiting"),
        SYNCHRONISED("synchronised"),
        HOLDOVER("holdover"),
        FROZEN("frozen"),
    }

    /** A new link: what was measured on another path no longer counts. */
    @Synchronized
    fun linkUp() {
        estimator = OffsetEstimator()
        exchanges = 0
    }

    /** No link: the last estimate is held. */
    @Synchronized
    fun linkDown() {
        if (state.value == State.SYNCHRONISED) state.value = State.HOLDOVER
    }

    @Synchronized
    fun add(exchange: TimeExchange) {
        val latest = estimator.add(exchange)
        estimate.value = latest
        if (++exchanges < FIRST_EXCHANGES) return
        if (exchange.t4 >= nextSteerNanos) {
            stamps.steerTo(latest.offsetNanos, exchange.t4)
            nextSteerNanos = exchange.t4 + STEER_INTERVAL_NANOS
        }
        if (state.value != State.FROZEN) state.value = State.SYNCHRONISED
    }

    /**
     * Waits until stamps can be made: for a good first estimate, but at most [FIRST_ESTIMATE_LIMIT_MILLIS]; then the
     * device's own wall clock serves, and the state stays waiting until there is an estimate.
     */
    suspend fun awaitStamps() {
        if (stamps.isSet) return
        withTimeoutOrNull(FIRST_ESTIMATE_LIMIT_MILLIS) { state.first { it != State.WAITING } }
        setFromWallClock()
    }

    @Synchronized
    private fun setFromWallClock() {
        if (stamps.isSet) return
        val nowNanos = deviceClock.nowNanos()
        stamps.steerTo(System.currentTimeMillis() * NANOS_PER_MILLI - nowNanos, nowNanos)
    }

    /** Fixes the map at its present offset for good. */
    @Synchronized
    fun freeze() {
        if (state.value == State.FROZEN) return
        stamps.freeze(deviceClock.nowNanos())
        state.value = State.FROZEN
    }

    /** The present ROS time by the latest estimate, 0 before there is one. */
    fun rosNowNanos(): Long = estimate.value?.let { deviceClock.nowNanos() + it.offsetNanos } ?: 0

    /** The state and the latest estimate, null before there is one. */
    val status: Pair<State, OffsetEstimate?> get() = state.value to estimate.value

    private companion object {
        /** A tenth of the first burst: the least round trip of so many is within jitter of the best on a quiet link. */
        const val FIRST_EXCHANGES = 16
        const val STEER_INTERVAL_NANOS = 1_000_000_000L
        const val FIRST_ESTIMATE_LIMIT_MILLIS = 5_000L
        const val NANOS_PER_MILLI = 1_000_000L
    }
}
