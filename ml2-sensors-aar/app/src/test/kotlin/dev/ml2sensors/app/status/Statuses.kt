package dev.ml2sensors.app.status

import dev.ml2sensors.wire.Status

/** A status with what a test says, and nothing of interest besides. */
internal fun appStatus(
    state: String = "connected",
    streams: List<StreamStatus> = emptyList(),
    permissions: Map<String, Boolean> = emptyMap(),
    reason: String = "",
    news: String = "",
    paired: List<String> = listOf("desk"),
    clock: Status.Clock? = null,
    thermal: String? = "none",
    batteryCelsius: Double? = null,
): AppStatus = AppStatus(
    version = "0.1.0",
    state,
    receiver = "desk",
    reason,
    news,
    paired,
    permissions,
    clock,
    thermal,
    batteryCelsius,
    atBoot = false,
    coolsDown = false,
    streams,
)

internal fun streamStatus(
    id: String,
    state: String = "accepted",
    reason: String = "",
    produced: Long = 0,
    dropped: Long = 0,
    resting: Boolean = false,
): StreamStatus = StreamStatus(id, state, reason, produced, dropped, resting)
