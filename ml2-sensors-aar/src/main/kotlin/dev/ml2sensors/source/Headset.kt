package dev.ml2sensors.source

import dev.ml2sensors.table.StreamSpec
import kotlinx.coroutines.flow.Flow

/**
 * A headset's senses, real, simulated or recorded.
 *
 * Streams that are made of others (`imu_*` of `accel_*` and `gyro_*`, `tf` of the poses) are the library's work; a
 * headset answers for the sensors themselves.
 */
public interface Headset : AutoCloseable {
    /** Does not change. */
    public val identity: Identity

    /** The timebase of all its samples. */
    public val clock: DeviceClock

    /** Does not change. */
    public val timeline: Timeline

    /** Whether each Android permission that its streams need is granted now; empty where there are none. */
    public val permissions: Map<String, Boolean> get() = emptyMap()

    /** How hot it is now; null where the platform does not tell. */
    public val thermal: Thermal? get() = null

    /** By stream id, the clock that the platform was found to stamp it with; empty where that is not in question. */
    public val timestampBases: Map<String, ClockDomain> get() = emptyMap()

    /** By stream id, why it delivers nothing at present although it runs, and goes on by itself; empty while all do. */
    public val holds: Map<String, String> get() = emptyMap()

    /**
     * Whether [stream] can run with the values asked for, and with which it will. Starts no stream; it may open a sensor
     * for a moment, to ask it what it has here.
     */
    public fun negotiate(stream: StreamSpec, requested: StreamValues): Answer

    /**
     * The samples of a stream, in order of capture; nothing runs before the flow is collected. [ImageSample]s are
     * borrowed: released when the collector returns. Ends when the headset is closed or a recording is over; fails
     * with the source's typed error.
     *
     * @param values as answered by [negotiate].
     */
    public fun samples(stream: StreamSpec, values: StreamValues): Flow<Sample>

    /** Who it is: [deviceId] stays over restarts, [name] is for people. */
    public data class Identity(val deviceId: String, val name: String)

    /** Where capture times come from. */
    public enum class Timeline {
        /** Sensors run as time does and cannot wait for a reader. */
        LIVE,

        /** Recorded instants, delivered unchanged up to one constant; poses are sent as recorded. */
        RECORDED,
    }
}

/** What a headset says to a request. */
public sealed interface Answer {
    /** It runs with the [values] asked for. */
    public data class Applied(val values: StreamValues) : Answer

    /** It runs with other [values], for this [reason]. */
    public data class Adjusted(val values: StreamValues, val reason: String) : Answer

    /**
     * It does not run.
     *
     * @property reason for people: what was expected and found.
     * @property permission the Android permission to request for it, null when that is not what is missing.
     */
    public data class Refused(val reason: String, val permission: String? = null) : Answer
}

/** The values a stream runs with by this answer, null when it does not. */
internal val Answer.acceptedValues: StreamValues?
    get() =
        when (this) {
            is Answer.Applied -> values
            is Answer.Adjusted -> values
            is Answer.Refused -> null
        }
