package dev.ml2sensors.app.status

import dev.ml2sensors.wire.Status
import kotlinx.serialization.SerialName
import kotlinx.serialization.Serializable
import kotlinx.serialization.Transient

/** Characters of what others say, so that a line of logcat has room for it. */
internal const val TEXT_LIMIT = 200

/**
 * How the app stands at one instant.
 *
 * @property state `off`, or that of the streamer: `connecting`, `connected`.
 * @property receiver by name or address, empty while it is not known.
 * @property reason why it is not connected; may be empty.
 * @property news of what was asked for last, good or bad; may be empty.
 * @property paired the names of the receivers that the headset is paired with.
 * @property thermal how hot the headset is, by the words of PROTOCOL.md.
 * @property permissions Android's, that streams need, and whether each is granted.
 */
@Serializable
internal class AppStatus(
    val version: String,
    val state: String,
    val receiver: String,
    val reason: String,
    val news: String,
    val paired: List<String>,
    val permissions: Map<String, Boolean>,
    val clock: Status.Clock?,
    val thermal: String?,
    @SerialName("battery_celsius") val batteryCelsius: Double?,
    @SerialName("at_boot") val atBoot: Boolean,
    @SerialName("cools_down") val coolsDown: Boolean,
    @Transient val streams: List<StreamStatus> = emptyList(),
)
