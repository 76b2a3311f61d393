package dev.ml2sensors.session

import dev.ml2sensors.table.StreamTable
import dev.ml2sensors.wire.ErrorCode
import dev.ml2sensors.wire.ProtocolException
import dev.ml2sensors.wire.RosLanes
import dev.ml2sensors.wire.Welcome
import dev.ml2sensors.wire.violation
import kotlinx.coroutines.Deferred
import kotlinx.coroutines.async
import kotlinx.coroutines.coroutineScope
import kotlinx.coroutines.selects.select
import kotlinx.coroutines.withTimeoutOrNull
import kotlin.time.Duration

/** Returns the result of [exchange], or fails with [ErrorCode.TIMEOUT] after [limit]. */
internal suspend fun <T : Any> handshake(awaited: String, limit: Duration, exchange: suspend () -> T?): T =
    withTimeoutOrNull(limit) { exchange() }
        ?: throw ProtocolException(ErrorCode.TIMEOUT, "expected $awaited within $limit")

/** Returns the result of [exchange], or null if [stop] completes first. */
internal suspend fun <T : Any> unlessStopped(stop: Deferred<*>, exchange: suspend () -> T): T? =
    coroutineScope {
        val result = async { exchange() }
        select {
            result.onAwait { it }
            stop.onAwait { null }
        }.also { result.cancel() }
    }

/** Returns how it violates PROTOCOL.md, or null if it is valid; a session that [hasOpenings] needs more lanes. */
internal fun Welcome.violation(hasOpenings: Boolean): String? {
    val ofOpenings = if (hasOpenings) RosLanes.ALL else emptyList()
    val missing = listOf(SessionLanes.TIME, StreamTable.sensorsLane.name) + ofOpenings - tickets.keys
    val isInTime = timeouts.handshakeSeconds > 0 && timeouts.pingSeconds > 0 && timeouts.deadSeconds > 0
    val counts = received.orEmpty().values + limits.dataBytes
    return when {
        missing.isNotEmpty() -> "no tickets for $missing"
        !isInTime -> "timeouts of 0 or less"
        counts.any { it < 0 } -> "counts below 0"
        else -> violation(name, software)
    }
}
