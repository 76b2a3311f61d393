package dev.ml2sensors.session

import dev.ml2sensors.wire.ErrorCode
import dev.ml2sensors.wire.ProtocolException
import dev.ml2sensors.wire.Welcome
import kotlinx.coroutines.Deferred
import kotlinx.coroutines.async
import kotlinx.coroutines.coroutineScope
import kotlinx.coroutines.selects.select
import kotlinx.coroutines.withTimeoutOrNull
import kotlin.time.Duration

/** What [exchange] gives, which must not take longer than [limit]. */
internal suspend fun <T : Any> handshake(awaited: String, limit: Duration, exchange: suspend () -> T?): T =
    withTimeoutOrNull(limit) { exchange() }
        ?: throw ProtocolException(ErrorCode.TIMEOUT, "expected $awaited within $limit")

/** What [exchange] gives, null when [stop] completes before. */
internal suspend fun <T : Any> unlessStopped(stop: Deferred<*>, exchange: suspend () -> T): T? =
    coroutineScope {
        val result = async { exchange() }
        select {
            result.onAwait { it }
            stop.onAwait { null }
        }.also { result.cancel() }
    }

/** What PROTOCOL.md does not allow in it, null when it is sound. */
internal fun Welcome.violation(): String? {
    val missing = listOf(SessionLanes.TIME, SessionLanes.SENSORS) - tickets.keys
    val isInTime = timeouts.handshakeSeconds > 0 && timeouts.pingSeconds > 0 && timeouts.deadSeconds > 0
    val counts = received.orEmpty().values + limits.dataBytes
    return when {
        missing.isNotEmpty() -> "no tickets for $missing"
        !isInTime -> "timeouts that are not above 0"
        counts.any { it < 0 } -> "counts below 0"
        else -> null
    }
}
