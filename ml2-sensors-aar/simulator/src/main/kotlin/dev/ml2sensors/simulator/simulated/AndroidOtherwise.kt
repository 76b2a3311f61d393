package dev.ml2sensors.simulator.simulated

import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.source.isVideo
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable

/**
 * A fact of config/facts.yaml that does not hold on the simulated headset: Android refuses the [streams] concerned.
 *
 * @property reason what Android's source of the stream says then; its argument is the value of [key].
 */
internal enum class AndroidOtherwise(
    fact: String,
    meaning: String,
    private val streams: (StreamSpec, StreamValues) -> Boolean,
    val reason: (String) -> String,
) {
    CLOCKS(
        "android_clocks",
        "the clock of Android's sensors in ns, which is none of the headset's",
        { stream, _ -> stream in sensorManagerSignals() },
        { "expected timestamps within a second of CLOCK_BOOTTIME or CLOCK_MONOTONIC, found $it" },
    ),
    NAMES(
        "sensor_names",
        "the names of all sensors that Android lists",
        { stream, _ -> stream in sensorManagerSignals() },
        { "this headset lists no single sensor of the name; it lists: $it" },
    ),
    CAMERAS(
        "color_camera_ids",
        "the ids of all cameras that Android lists",
        { stream, _ -> stream == StreamTable.color },
        { "this headset lists no camera 1; it lists: $it" },
    ),
    JPEG(
        "jpeg_encoder",
        "why Android encodes no JPEG",
        { stream, values -> stream == StreamTable.color && !values.isVideo },
        { "Android failed to encode a JPEG: $it" },
    ),
    VIDEO(
        "video_encoders",
        "the encoders of video, none of which takes the pictures",
        { _, values -> values.isVideo },
        { "no encoder for h264 takes the pictures; this headset has: $it" },
    ),
    CONTROLLER(
        "controller_library",
        "why the library of the controller's buttons cannot be loaded",
        { stream, values -> stream == StreamTable.controllerJoy && values.backend == "sdk" },
        { "not available: libinput.magicleap.so ($it)" },
    ),
    SYMBOLS(
        "vendor_symbols",
        "a function that the vendor's library of tracking and cameras does not have",
        { _, values -> values.backend == "sdk" },
        { "not available: libperception.magicleap.so/$it" },
    ),
    ;

    val key: SimulationKey = SimulationKey.text("assume.$fact", "$meaning; empty: as assumed")

    fun concerns(stream: StreamSpec, values: StreamValues): Boolean = streams(stream, values)
}
