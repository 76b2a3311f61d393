package dev.ml2sensors.app.screen

import dev.ml2sensors.app.R
import dev.ml2sensors.app.robot.RobotArm
import dev.ml2sensors.app.robot.RobotStatus
import dev.ml2sensors.app.status.AppStatus
import dev.ml2sensors.app.status.StreamStatus
import dev.ml2sensors.message.PoseStamped

/** A string resource and its arguments. */
internal data class StringResource(val id: Int, val values: List<Any> = emptyList()) {
    constructor(id: Int, vararg values: Any) : this(id, values.toList())
}

/**
 * The app's status as the screen shows it.
 *
 * @property detail the result of the last command, or why the app is not connected; may be empty.
 * @property isOn true if the app streams or tries to, so that the button stops it.
 * @property hasRobot true if there is a robot's arm to send to its tag.
 */
internal data class Screen(
    val title: StringResource,
    val detail: String,
    val clock: StringResource?,
    val heat: StringResource,
    val rows: List<Row>,
    val permissionRequest: PermissionRequest?,
    val isOn: Boolean,
    val hasRobot: Boolean,
) {
    /** A row for one stream, or for a topic of the robot. [isWarning] highlights it. */
    data class Row(val stream: String, val text: StringResource, val isWarning: Boolean)

    companion object {
        fun of(status: AppStatus, rates: Map<String, Double>, declined: Set<String>): Screen = Screen(
            title(status),
            status.lastResult.ifEmpty { status.reason },
            status.clock?.let { clock(it.state, it.uncertaintyNanos) },
            heat(status),
            status.streams.map {
                row(it, rates[it.id])
            } + status.robot?.let { rows(it, rates[RobotArm.TAG]) }.orEmpty(),
            PermissionRequest.next(status, declined),
            isOn = status.state != "off",
            hasRobot = status.robot != null,
        )

        private fun title(status: AppStatus): StringResource = when {
            status.state == "connected" -> StringResource(R.string.connected, status.receiver)
            status.state != "off" -> StringResource(R.string.connecting)
            status.paired.isEmpty() -> StringResource(R.string.not_paired)
            else -> StringResource(R.string.off)
        }

        private fun clock(state: String, uncertaintyNanos: Long): StringResource = when (state) {
            "waiting" -> StringResource(R.string.clock_waiting)
            else -> StringResource(R.string.clock, uncertaintyNanos / NANOS_PER_MILLI)
        }

        private fun heat(status: AppStatus): StringResource {
            val battery = status.batteryCelsius ?: return StringResource(R.string.heat, status.thermal ?: UNKNOWN)
            return StringResource(R.string.heat_and_battery, status.thermal ?: UNKNOWN, battery)
        }

        private fun row(stream: StreamStatus, rateHz: Double?): Row = when {
            stream.state != "running" -> Row(
                stream.id,
                StringResource(R.string.plain, stream.reason),
                isWarning = true,
            )

            stream.isPaused -> Row(stream.id, StringResource(R.string.paused), isWarning = true)

            rateHz == null -> Row(stream.id, StringResource(R.string.starting), isWarning = false)

            stream.dropped == 0L -> Row(stream.id, StringResource(R.string.rate, rateHz), isWarning = false)

            else -> Row(stream.id, StringResource(R.string.rate_and_loss, rateHz, stream.dropped), isWarning = true)
        }

        private fun rows(robot: RobotStatus, rateHz: Double?): List<Row> = listOf(
            row(RobotArm.TAG, robot.tagReason, tag(robot.tag, rateHz)),
            row(RobotArm.TARGET, robot.targetReason, StringResource(R.string.sent, robot.sent)),
        )

        private fun row(topic: String, reason: String, text: StringResource): Row =
            if (reason.isEmpty()) Row(topic, text, false) else Row(topic, StringResource(R.string.plain, reason), true)

        private fun tag(tag: PoseStamped?, rateHz: Double?): StringResource {
            val (at, frame) = tag?.run { pose.position to header.frameId } ?: return StringResource(R.string.starting)
            return StringResource(R.string.tag, at.x, at.y, at.z, frame, rateHz ?: 0.0)
        }

        private const val UNKNOWN = "?"
        private const val NANOS_PER_MILLI = 1e6
    }
}
