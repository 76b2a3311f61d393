package dev.ml2sensors.source

import dev.ml2sensors.table.StreamSpec
import kotlinx.coroutines.flow.Flow

/**
 * The sensors of a headset, real, simulated or recorded.
 *
 * The library adds the derived streams (`imu_*` of `accel_*` and `gyro_*`, `tf` of the poses); a headset implements the
 * sensors themselves.
 */
public interface Headset : AutoCloseable {
    /** The identity; does not change. */
    public val identity: Identity

    /** The clock of all its samples. */
    public val clock: DeviceClock

    /** Does not change. */
    public val timeline: Timeline

    /** The Android permissions that its streams need, and whether each is granted now; empty if there are none. */
    public val permissions: Map<String, Boolean> get() = emptyMap()

    /** The present thermal state; null if the platform does not report one. */
    public val thermal: Thermal? get() = null

    /** The clock that was found to stamp each stream, by stream id; empty if it is not in question. */
    public val timestampBases: Map<String, ClockDomain> get() = emptyMap()

    /** The time for which the device was suspended since it booted, in ns; 0 if it never is. [clock] includes it. */
    public val suspendedNanos: Long get() = 0

    /**
     * The reason why a running stream is held at present, by stream id; it continues by itself. Empty while no stream
     * is held.
     */
    public val holds: Map<String, String> get() = emptyMap()

    /**
     * The reason why its sensors may deliver nothing at present, such as a headset that is not worn; null while it is in
     * use. A stream that is silent meanwhile has not failed.
     */
    public val sleepReason: String? get() = null

    /** The encoders of video, which is refused without them; null if the platform has none. */
    public val videoEncoders: VideoEncoders? get() = null

    /**
     * Returns whether [stream] can run with the requested values, and with which values it will. Starts no stream; it
     * may open a sensor briefly to query it.
     */
    public fun negotiate(stream: StreamSpec, requested: StreamValues): Answer

    /**
     * Returns the samples of a stream, in order of capture; nothing runs before the flow is collected. An [ImageSample]
     * is released when the collector returns. The flow ends when the headset is closed or a recording is over, and
     * fails with the source's typed error.
     *
     * @param values as answered by [negotiate].
     */
    public fun samples(stream: StreamSpec, values: StreamValues): Flow<Sample>

    /** The identity of a device: [deviceId] is stable over restarts, [name] is for people. */
    public data class Identity(val deviceId: String, val name: String)

    /** The origin of capture times. */
    public enum class Timeline {
        /** Live sensors, which cannot wait for a reader. */
        LIVE,

        /** Recorded times, delivered unchanged except for one constant; poses are sent as recorded. */
        RECORDED,
    }
}

/** The answer to a request for a stream. */
public sealed interface Answer {
    /** The stream runs with the requested [values]. */
    public data class Applied(val values: StreamValues) : Answer

    /** The stream runs with adjusted [values]; [reason] says why. */
    public data class Adjusted(val values: StreamValues, val reason: String) : Answer

    /**
     * The stream does not run.
     *
     * @property reason for people: what was expected and found.
     * @property permission the Android permission to request for it, null if that is not what is missing.
     */
    public data class Refused(val reason: String, val permission: String? = null) : Answer
}

/** The values that the stream runs with, null if it is refused. */
internal val Answer.acceptedValues: StreamValues?
    get() =
        when (this) {
            is Answer.Applied -> values
            is Answer.Adjusted -> values
            is Answer.Refused -> null
        }
