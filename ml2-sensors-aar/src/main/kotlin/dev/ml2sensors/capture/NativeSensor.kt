package dev.ml2sensors.capture

import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable

/** The backends of the native library: ml2s_backend. [id] is the name in the stream table. */
internal enum class NativeBackend(val id: String, internal val code: Int) {
    /** The vendor's C SDK. */
    SDK("sdk", 0),

    /** OpenXR with the vendor's extensions; see [NativeLibrary.useOpenXr]. */
    OPENXR("openxr", 1),
}

/**
 * The cameras that are opened together: ml2s_sensor.
 *
 * @property hasOneStream true if only one of its streams can run at a time.
 */
internal enum class PixelSensor(
    internal val code: Int,
    internal val streams: Set<StreamSpec>,
    internal val hasOneStream: Boolean,
) {
    /** Depth, or the infrared image that it is made of. */
    DEPTH(1, setOf(StreamTable.depth, StreamTable.infra), hasOneStream = true),

    /** The tracking cameras. */
    WORLD(2, setOf(StreamTable.worldLeft, StreamTable.worldRight, StreamTable.worldCenter), hasOneStream = false),

    /** The eye cameras. */
    EYE(
        3,
        setOf(
            StreamTable.eyeNasalLeft,
            StreamTable.eyeNasalRight,
            StreamTable.eyeTempleLeft,
            StreamTable.eyeTempleRight,
        ),
        hasOneStream = false,
    ),

    /** The colour camera, with or without what the headset shows; by OpenXR only. */
    COLOR(5, setOf(StreamTable.color, StreamTable.mixedReality), hasOneStream = true),
}

/**
 * The tracked objects: ml2s_sensor.
 *
 * @property mostReadings how many readings one poll has.
 * @property rateHz how often it is polled.
 * @property backends those that can read it.
 */
internal enum class ReadingSensor(
    internal val code: Int,
    internal val streams: Set<StreamSpec>,
    internal val mostReadings: Int = 1,
    internal val rateHz: Int = 60,
    internal val backends: Set<NativeBackend> = NativeBackend.entries.toSet(),
) {
    /** The headset in the world. */
    HEAD(4, setOf(StreamTable.headPose)),

    /** The common gaze of both eyes. */
    GAZE(6, setOf(StreamTable.gaze)),

    /** The 26 joints of each hand. */
    HANDS(7, setOf(StreamTable.handLeft, StreamTable.handRight), mostReadings = 52),

    /** The hand-held controller. */
    CONTROLLER(8, setOf(StreamTable.controller)),

    /** Its buttons, trigger and touchpad. */
    CONTROLLER_INPUT(9, setOf(StreamTable.controllerJoy)),

    /** The markers that the headset's own detector sees. */
    MARKERS(10, setOf(StreamTable.markers), mostReadings = 32, rateHz = 30, backends = setOf(NativeBackend.OPENXR)),

    /** The saved map in which the headset is localized. */
    MAP(11, setOf(StreamTable.map), rateHz = 30, backends = setOf(NativeBackend.OPENXR)),
}

/** ml2s_stream: the number of a stream is its place in the table. */
internal val StreamSpec.number: Int get() = StreamTable.all.indexOf(this)

/** ML2S_STREAM_BITs. */
internal fun Iterable<StreamSpec>.bits(): Long = fold(0L) { bits, stream -> bits or (1L shl stream.number) }
