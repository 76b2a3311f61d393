package dev.ml2sensors.source

import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.TopicSpec
import kotlinx.serialization.SerialName
import kotlinx.serialization.Serializable

/**
 * The configured values of one stream, with the keys of its section in config.yaml; null if the section has no such
 * key.
 *
 * @property stream the device's number of the mode: 0 or 1.
 * @property width of the image in pixels.
 * @property height of the image in pixels.
 * @property rateHz captures per second.
 * @property format of the images, such as `Grayscale`, `jpeg`, [H264], [H264_FOXGLOVE] or `Depth32`.
 * @property quality of `jpeg`: 1 is the smallest image, 100 the best.
 * @property confidence true to publish the confidence image, too.
 * @property flags true to publish the image of the device's flags, too.
 * @property radial true for distances from the camera instead of z along its optical axis.
 * @property accelerationVariance variance of each axis, (m/s^2)^2, for the message's covariance.
 * @property angularVelocityVariance variance of each axis, (rad/s)^2, for the message's covariance.
 * @property layout of the transform tree: `flat` or `rig`.
 * @property backend `sdk` or `openxr`.
 * @property cameraId Camera2's number of the RGB camera: 0 or 1.
 * @property bitRateMbit of video, in Mbit/s: 1 to 100.
 * @property markerType of markers: `april_tag`, `aruco` or `qr`.
 * @property dictionary of markers, such as `36h11` or `5X5_100`.
 * @property sizeM side of a marker's black square in metres.
 * @property profile of the detector of markers: `default`, `speed`, `accuracy`, `small_targets` or `large_fov`.
 * @property camera that looks for markers: `auto`, `world` or `rgb`.
 * @property localize name or UUID of the map to localize in; empty for that of the headset's settings.
 * @property minConfidence of a map's pose: `poor`, `fair`, `good` or `excellent`.
 */
@Serializable
public data class StreamValues(
    val stream: Int? = null,
    @SerialName("resolution_width") val width: Int? = null,
    @SerialName("resolution_height") val height: Int? = null,
    @SerialName("update_rate") val rateHz: Int? = null,
    val format: String? = null,
    val quality: Int? = null,
    val confidence: Boolean? = null,
    val flags: Boolean? = null,
    val radial: Boolean? = null,
    @SerialName("linear_acceleration_variance") val accelerationVariance: Double? = null,
    @SerialName("angular_velocity_variance") val angularVelocityVariance: Double? = null,
    val layout: String? = null,
    val backend: String? = null,
    @SerialName("camera_id") val cameraId: Int? = null,
    @SerialName("bit_rate_mbit") val bitRateMbit: Int? = null,
    @SerialName("type") val markerType: String? = null,
    val dictionary: String? = null,
    @SerialName("size_m") val sizeM: Double? = null,
    val profile: String? = null,
    val camera: String? = null,
    val localize: String? = null,
    @SerialName("min_confidence") val minConfidence: String? = null,
) {
    public companion object {
        /** The format of video for image_transport. */
        public const val H264: String = "h264"

        /** The format of video for Foxglove. */
        public const val H264_FOXGLOVE: String = "h264_foxglove"
    }
}

/** Returns the default values of a stream: the first mode of a camera; none for other streams. */
public fun StreamSpec.defaultValues(): StreamValues {
    val mode = modes.firstOrNull() ?: return StreamValues()
    val (width, height) = mode.resolutions.first()
    return StreamValues(mode.stream, width, height, mode.rates.first(), mode.formats.first())
}

/** Returns these values, with the default ones of a stream's mode where they are missing. */
internal fun StreamValues.orDefaultsOf(spec: StreamSpec): StreamValues = spec.defaultValues().let {
    copy(
        stream = stream ?: it.stream,
        width = width ?: it.width,
        height = height ?: it.height,
        rateHz = rateHz ?: it.rateHz,
        format = format ?: it.format,
    )
}

/** Returns the topics that [values] enable, in the order of the table; a camera without a format has its default. */
internal fun StreamSpec.topics(values: StreamValues): List<TopicSpec> {
    val whole = values.orDefaultsOf(this)
    return topics.filter { whole.enables(it.condition) }
}

/** Returns true if these values enable a topic with this [condition] of the stream table. */
private fun StreamValues.enables(condition: String?): Boolean =
    when (condition) {
        null -> true

        "confidence=true" -> confidence == true

        "flags=true" -> flags == true

        "layout=rig" -> layout == "rig"

        else -> format == condition.substringAfter("format=", "").ifEmpty {
            error("the stream table has an unknown condition $condition")
        }
    }

/** True if they ask for video. */
internal val StreamValues.isVideo: Boolean
    get() = format == StreamValues.H264 || format == StreamValues.H264_FOXGLOVE

/** Returns the video that a camera's values ask for; null if they ask for another format. */
internal fun StreamValues.video(): VideoSettings? {
    if (!isVideo) return null
    return VideoSettings(
        checkNotNull(width),
        checkNotNull(height),
        checkNotNull(rateHz),
        (bitRateMbit ?: DEFAULT_BIT_RATE_MBIT) * BITS_PER_MBIT,
    )
}

private const val DEFAULT_BIT_RATE_MBIT = 8
private const val BITS_PER_MBIT = 1_000_000
