package dev.ml2sensors.source

import dev.ml2sensors.message.Point
import dev.ml2sensors.message.Pose
import dev.ml2sensors.message.Quaternion
import dev.ml2sensors.message.Transform
import kotlin.Double.Companion.NaN

/**
 * One reading of one sensor.
 *
 * [captureNanos] is its time (centre of exposure for cameras) on the device timebase, [DeviceClock].
 */
public sealed interface Sample {
    public val captureNanos: Long
}

/** Three axes [x], [y], [z] of the sensor's own Android frame: m/s^2, rad/s or tesla. */
public class VectorSample(
    override val captureNanos: Long,
    public val x: Double,
    public val y: Double,
    public val z: Double,
) : Sample

/** The [angularVelocity] in rad/s and the [linearAcceleration] in m/s^2 at the time of the gyroscope's reading. */
internal class InertialSample(
    val angularVelocity: VectorSample,
    val linearAcceleration: VectorSample,
) : Sample {
    override val captureNanos: Long get() = angularVelocity.captureNanos
}

/** One number, [value], in the unit of the ROS type that the stream table gives its topic, such as lux or pascal. */
public class ScalarSample(override val captureNanos: Long, public val value: Double) : Sample

/**
 * A pose in the world frame, `magicleap_world` (REP-103: x forward, y left, z up; metres).
 *
 * [pose] is null while it is not tracked. [isInNewWorld] means that the world has a new origin, so earlier poses no
 * longer apply. [condition] says how well the head is tracked, or how well the eyes are known; null if the device does
 * not say it.
 */
public class PoseSample(
    override val captureNanos: Long,
    public val pose: Transform?,
    public val isInNewWorld: Boolean = false,
    public val condition: Condition? = null,
) : Sample

/**
 * The judgement of the headset on how well it perceives something, in words.
 *
 * @property isGood true if samples can be relied on.
 * @property message what is so, for people.
 * @property values details, by name.
 */
public data class Condition(val isGood: Boolean, val message: String, val values: Map<String, String>) {
    internal companion object {
        /** The value of what the device has not said yet. */
        const val NOT_SAID = "not_said"
    }
}

/**
 * The joints of a hand: [poses] in the world frame, always the 26 of OpenXR's XrHandJointEXT in its order. Joints that
 * are not tracked are [UNTRACKED].
 */
public class PosesSample(override val captureNanos: Long, public val poses: List<Pose>) : Sample {
    public companion object {
        /** A pose of NaN. */
        public val UNTRACKED: Pose = Pose(Point(NaN, NaN, NaN), Quaternion(NaN, NaN, NaN, NaN))
    }
}

/** The [markers] that the headset tracks at one instant, each with another frame; there may be none. */
public class MarkersSample(override val captureNanos: Long, public val markers: List<Marker>) : Sample

/**
 * A marker in the world frame.
 *
 * @property frame its name in the transform tree: `tag36h11:7`, `marker_7`, or `qr_` and a hash of the content.
 * @property content its number, or the text of a QR code.
 * @property pose its centre. Axes of ArUco and QR: x right, y up, z out of the face; of AprilTag: x right, y down, z into
 *   the face.
 * @property sizeM side of its black square in metres.
 * @property reprojectionErrorM how far off its corners are, metres.
 */
public class Marker(
    public val frame: String,
    public val content: String,
    public val pose: Transform,
    public val sizeM: Double,
    public val reprojectionErrorM: Double,
)

/**
 * The headset's localization in a saved map at one instant.
 *
 * @property origin the origin of the map in the world frame, z up; null while the headset is not in the map that was
 *   asked for, with enough confidence.
 * @property state what the headset says of it.
 */
public class MapSample(
    override val captureNanos: Long,
    public val origin: Transform?,
    public val state: MapState,
) : Sample

/**
 * The localization of the headset, in its own words.
 *
 * @property localization `unknown`, `not_localized`, `localized`, `pending` or `sleeping_before_retry`.
 * @property confidence `poor`, `fair`, `good` or `excellent`.
 * @property errors why it is low: `unknown`, `out_of_mapped_area`, `low_feature_count`, `excessive_motion`, `low_light`
 *   and `headpose`.
 * @property name of the current map; empty without one.
 * @property uuid of the current map; empty without one.
 * @property type of the current map: `on_device` or `cloud`.
 */
public data class MapState(
    val localization: String,
    val confidence: String,
    val errors: List<String>,
    val name: String,
    val uuid: String,
    val type: String,
) {
    internal companion object {
        /** The confidences, the least first. */
        val CONFIDENCES: List<String> = listOf("poor", "fair", "good", "excellent")
    }
}

/**
 * Buttons, trigger and touchpad of the controller.
 *
 * @property trigger 0 released, 1 pulled.
 * @property bumper true while it is pressed.
 * @property menu true while the menu button is pressed.
 * @property isTouched true while a finger is on the touchpad; otherwise [touchX], [touchY] and [force] are 0.
 * @property touchX place of the finger, -1 left to 1 right.
 * @property touchY place of the finger, -1 near to 1 far.
 * @property force how hard it presses, 0 to 1.
 */
public class InputSample(
    override val captureNanos: Long,
    public val trigger: Float,
    public val bumper: Boolean,
    public val menu: Boolean,
    public val isTouched: Boolean,
    public val touchX: Float,
    public val touchY: Float,
    public val force: Float,
) : Sample

/**
 * State of the battery; NaN where unknown.
 *
 * @property voltage volt.
 * @property current ampere, negative when discharging.
 * @property percentage fraction left, 0 to 1.
 * @property status what the charger does with it.
 * @property temperature degrees Celsius.
 */
public class BatterySample(
    override val captureNanos: Long,
    public val voltage: Float,
    public val current: Float,
    public val percentage: Float,
    public val status: ChargeStatus,
    public val temperature: Float = Float.NaN,
) : Sample

/** The charging state of a battery; the numbers are power_supply_status of sensor_msgs/BatteryState. */
public enum class ChargeStatus(internal val rosNumber: UByte) {
    /** The device does not know. */
    UNKNOWN(0u),

    /** A charger fills the battery. */
    CHARGING(1u),

    /** The headset runs on the battery. */
    DISCHARGING(2u),

    /** A charger is connected, and the battery is neither charged nor full. */
    NOT_CHARGING(3u),

    /** A charger is connected, and nothing is left to charge. */
    FULL(4u),
}

/** [count] readings that a source could not deliver, for this [reason]. */
public class LostSamples(
    override val captureNanos: Long,
    public val count: Int,
    public val reason: DropReason,
) : Sample

/** The reason why a message was produced but not sent; [wireName] as in PROTOCOL.md, Accounting. */
public enum class DropReason(public val wireName: String) {
    /** The lane's queue was full, and this was the oldest message in it, or an image that was about to become video. */
    QUEUE_FULL("queue_full"),

    /** The source had no free buffer. */
    NO_BUFFER("no_buffer"),

    /** The encoder was behind, or left the image out. */
    ENCODER_BUSY("encoder_busy"),

    /** There was no session, or it ended before the message arrived. */
    LINK_DOWN("link_down"),

    /** Withheld after a backward step of ROS time. */
    CLOCK_STEP("clock_step"),

    /** The source missed its own schedule. */
    SOURCE_LATE("source_late"),

    /** The capture time was more than a second ahead of the device's clock. */
    FUTURE_CAPTURE("future_capture"),

    /**
     * The device delivered no usable picture: a damaged one, a duplicate, one of another size or of an unknown camera.
     */
    UNUSABLE("unusable"),

    /** Video before it was lost, so nobody can decode this image; the next key frame is asked for. */
    AWAITING_KEY_FRAME("awaiting_key_frame"),
}
