package dev.ml2sensors.source

import dev.ml2sensors.table.StreamSpec
import kotlinx.serialization.SerialName
import kotlinx.serialization.Serializable

/** The values of one stream, named as in config.yaml; null where the stream has no such key. Rates in Hz. */
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
