package dev.ml2sensors.source

import dev.ml2sensors.message.Pose
import dev.ml2sensors.message.Transform

/**
 * What a source delivers: one reading of one sensor.
 *
 * [captureNanos] is the instant of the reading (centre of exposure for cameras) on the device timebase,
 * [DeviceClock].
 */
public sealed interface Sample {
    public val captureNanos: Long
}

/** Three axes in the sensor's own Android frame: m/s^2, rad/s or tesla. */
public class VectorSample(
    override val captureNanos: Long,
    public val x: Double,
    public val y: Double,
    public val z: Double,
) : Sample

/** Both halves of an inertial unit at the instant of its gyroscope's reading; rad/s and m/s^2. */
public class InertialSample(
    public val angularVelocity: VectorSample,
    public val linearAcceleration: VectorSample,
) : Sample {
    override val captureNanos: Long get() = angularVelocity.captureNanos
}

/** One number: lux or pascal. */
public class ScalarSample(override val captureNanos: Long, public val value: Double) : Sample

/**
 * A pose in the world frame, `magicleap_world` (REP-103: x forward, y left, z up; metres).
 *
 * [pose] is null while it is not tracked. [isInNewWorld]: earlier poses mean nothing in the world of this one and of
 * those that follow.
 */
public class PoseSample(
    override val captureNanos: Long,
    public val pose: Transform?,
    public val isInNewWorld: Boolean = false,
) : Sample

/** The joints of a hand in the world frame; empty while the hand is not seen. */
public class PosesSample(override val captureNanos: Long, public val poses: List<Pose>) : Sample

/** State of the battery: volts, amperes (negative when discharging), 0..1; NaN where unknown. */
public class BatterySample(
    override val captureNanos: Long,
    public val voltage: Float,
    public val current: Float,
    public val percentage: Float,
    public val charging: Boolean,
) : Sample

/** [count] readings that a source knows it could not deliver. */
public class LostSamples(
    override val captureNanos: Long,
    public val count: Int,
    public val reason: DropReason,
) : Sample

/** Why a message was produced but not sent; [wireName] as in PROTOCOL.md, Accounting. */
public enum class DropReason(public val wireName: String) {
    QUEUE_FULL("queue_full"),
    NO_BUFFER("no_buffer"),
    ENCODER_BUSY("encoder_busy"),
    LINK_DOWN("link_down"),
    CLOCK_STEP("clock_step"),
    SOURCE_LATE("source_late"),
}
