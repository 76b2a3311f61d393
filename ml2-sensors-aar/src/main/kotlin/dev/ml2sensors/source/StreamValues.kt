package dev.ml2sensors.source

import dev.ml2sensors.table.StreamSpec
import kotlinx.serialization.SerialName
import kotlinx.serialization.Serializable

/**
 * The values of one stream, those of its section in config.yaml; null where the section has no such key.
 *
 * @property stream the device's number of the mode: 0 or 1.
 * @property width of the image in pixels.
 * @property height of the image in pixels.
 * @property rateHz captures per second.
 * @property format of the pixels, such as `Grayscale`, `jpeg` or `Depth32`.
 * @property confidence whether the confidence image is wanted, too.
 * @property flags whether the image of the device's flags is wanted, too.
 * @property radial whether depth is the distance from the camera instead of z along its optical axis.
 * @property accelerationVariance of each axis, (m/s^2)^2; goes into the message's covariance.
 * @property angularVelocityVariance of each axis, (rad/s)^2; goes into the message's covariance.
 * @property layout of the transform tree: `flat` or `rig`.
 * @property backend `sdk` or `openxr`.
 * @property cameraId Camera2's number of the RGB camera: 0 or 1.
 */
@Serializable
public data class StreamValues(
    val stream: Int? = null,
    @SerialName("resolution_width") val width: Int? = null,
    @SerialName("resolution_height") val height: Int? = null,
    @SerialName("update_rate") val rateHz: Int? = null,
    val format: String? = null,
    val confidence: Boolean? = null,
    val flags: Boolean? = null,
    val radial: Boolean? = null,
    @SerialName("linear_acceleration_variance") val accelerationVariance: Double? = null,
    @SerialName("angular_velocity_variance") val angularVelocityVariance: Double? = null,
    val layout: String? = null,
    val backend: String? = null,
    @SerialName("camera_id") val cameraId: Int? = null,
)

/** What a stream runs with where nothing else is asked for: the first mode of a camera; nothing for other streams. */
public fun StreamSpec.defaultValues(): StreamValues {
    val mode = modes.firstOrNull() ?: return StreamValues()
    val (width, height) = mode.resolutions.first()
    return StreamValues(mode.stream, width, height, mode.rates.first(), mode.formats.first())
}

/** Whether a topic with this [condition] of the stream table is on. */
internal fun StreamValues.switchesOn(condition: String?): Boolean =
    when (condition) {
        null -> true
        "confidence=true" -> confidence == true
        "flags=true" -> flags == true
        "layout=rig" -> layout == "rig"
        else -> error("the stream table has a condition $condition that no value answers")
    }
