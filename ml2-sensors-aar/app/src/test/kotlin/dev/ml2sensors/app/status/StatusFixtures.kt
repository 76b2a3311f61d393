package dev.ml2sensors.app.status

import dev.ml2sensors.app.robot.RobotStatus
import dev.ml2sensors.wire.Status

/** Returns a status with the values of a test and neutral defaults. */
internal fun appStatus(
    state: String = "connected",
    streams: List<StreamStatus> = emptyList(),
    permissions: Map<String, Boolean> = emptyMap(),
    reason: String = "",
    lastResult: String = "",
    paired: List<String> = listOf("desk"),
    clock: Status.Clock? = null,
    thermal: String? = "none",
    batteryCelsius: Double? = null,
    robot: RobotStatus? = null,
): AppStatus = AppStatus(
    version = "0.1.0",
    state,
    receiver = "desk",
    reason,
    lastResult,
    paired,
    permissions,
    clock,
    thermal,
    batteryCelsius,
    startAtBoot = false,
    pauseWhenHot = false,
    streams,
    robot,
)

internal fun streamStatus(
    id: String,
    state: String = "running",
    reason: String = "",
    produced: Long = 0,
    dropped: Long = 0,
    isPaused: Boolean = false,
): StreamStatus = StreamStatus(id, state, reason, produced, dropped, isPaused)
