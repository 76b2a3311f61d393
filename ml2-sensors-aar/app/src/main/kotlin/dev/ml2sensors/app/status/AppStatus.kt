package dev.ml2sensors.app.status

import dev.ml2sensors.app.robot.RobotArm
import dev.ml2sensors.app.robot.RobotStatus
import dev.ml2sensors.wire.Status
import kotlinx.serialization.SerialName
import kotlinx.serialization.Serializable
import kotlinx.serialization.Transient

/** The largest number of characters of a text from elsewhere, so that a line fits logcat. */
internal const val TEXT_LIMIT = 200

/**
 * The status of the app.
 *
 * @property state `off`, `connecting` or `connected`.
 * @property receiver the receiver's name or address; empty while it is not known.
 * @property reason why the app is not connected; may be empty.
 * @property lastResult the result of the last command, an error or a success; may be empty.
 * @property paired the names of the receivers that the headset is paired with.
 * @property permissions the Android permissions that streams need, and whether each is granted.
 * @property thermal the thermal status of the headset, as in PROTOCOL.md.
 * @property robot the status of the sample; null while it is not shown, or the app does not stream.
 */
@Serializable
internal class AppStatus(
    val version: String,
    val state: String,
    val receiver: String,
    val reason: String,
    @SerialName("news") val lastResult: String,
    val paired: List<String>,
    val permissions: Map<String, Boolean>,
    val clock: Status.Clock?,
    val thermal: String?,
    @SerialName("battery_celsius") val batteryCelsius: Double?,
    @SerialName("at_boot") val startAtBoot: Boolean,
    @SerialName("cools_down") val pauseWhenHot: Boolean,
    @Transient val streams: List<StreamStatus> = emptyList(),
    @Transient val robot: RobotStatus? = null,
) {
    /** The messages of each stream, and of the robot's tag, by what the screen calls them. */
    val counts: Map<String, Long>
        get() = streams.associate { it.id to it.produced } + listOfNotNull(robot?.let { RobotArm.TAG to it.received })
}
