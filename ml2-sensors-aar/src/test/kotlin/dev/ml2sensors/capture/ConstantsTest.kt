package dev.ml2sensors.capture

import dev.ml2sensors.table.StreamTable
import org.junit.jupiter.api.Test
import java.nio.file.Path
import kotlin.io.path.readText
import kotlin.test.assertEquals

/** The numbers that Kotlin and C share, read from the headers. */
class ConstantsTest {
    private val headers = listOf("sdk/ml2s.h", "generated/ml2s_streams.h")
        .joinToString("\n") { Path.of("../native", it).readText() }

    /** Returns the value of an enumerator: a number, or a bit such as `1u << 2`. */
    private fun value(name: String): Int {
        val match = Regex("""\bML2S_$name = (?:1u << )?(\d+),""").findAll(headers).single()
        val number = match.groupValues[1].toInt()
        return if ("<<" in match.value) 1 shl number else number
    }

    @Test
    fun streamsAreNumberedByTheirPlaceInTheTable() {
        for (stream in StreamTable.all) assertEquals(value("STREAM_${stream.id.uppercase()}"), stream.number)
    }

    @Test
    fun sensorsAndBackendsHaveTheNumbersOfTheLibrary() {
        for (sensor in PixelSensor.entries) assertEquals(value("SENSOR_${sensor.name}"), sensor.code)
        for (sensor in ReadingSensor.entries) assertEquals(value("SENSOR_${sensor.name}"), sensor.code)
        for (codec in ImageCodec.entries) assertEquals(value("CODEC_${codec.name}"), codec.code)
        for (backend in NativeBackend.entries) assertEquals(value("BACKEND_${backend.name}"), backend.code)
    }

    @Test
    fun slotsOfEncodedImagesHaveTheBitOfTheLibrary() {
        assertEquals("${SlotPool.ENCODED}u", Regex("#define ML2S_ENCODED (.*)").find(headers)?.groupValues?.get(1))
    }

    @Test
    fun bitsAreThoseOfTheLibrary() {
        val known = mapOf(
            "WANT_CONFIDENCE" to NativeSettings.WANT_CONFIDENCE,
            "WANT_FLAGS" to NativeSettings.WANT_FLAGS,
            "WANT_RADIAL" to NativeSettings.WANT_RADIAL,
            "HAS_POSE" to NativeFrame.HAS_POSE,
            "HAS_INTRINSICS" to NativeFrame.HAS_INTRINSICS,
            "HAS_EXPOSURE" to NativeFrame.HAS_EXPOSURE,
            "HAS_ANALOG_GAIN" to NativeFrame.HAS_ANALOG_GAIN,
            "HAS_DIGITAL_GAIN" to NativeFrame.HAS_DIGITAL_GAIN,
            "HAS_ILLUMINATION" to NativeFrame.HAS_ILLUMINATION,
            "LENS_PLUMB_BOB" to NativeFrame.LENS_PLUMB_BOB,
            "LENS_FISHEYE_TANGENTIAL" to NativeFrame.LENS_FISHEYE_TANGENTIAL,
            "TRACKING_RECOVERY_FAILED" to Reading.TRACKING_RECOVERY_FAILED,
            "TRACKING_NEW_SESSION" to Reading.TRACKING_NEW_SESSION,
            "INPUT_TRIGGER" to Reading.INPUT_TRIGGER,
            "INPUT_BUMPER" to Reading.INPUT_BUMPER,
            "INPUT_MENU" to Reading.INPUT_MENU,
            "INPUT_TOUCHED" to Reading.INPUT_TOUCHED,
            "INPUT_TOUCH_X" to Reading.INPUT_TOUCH_X,
            "INPUT_TOUCH_Y" to Reading.INPUT_TOUCH_Y,
            "INPUT_FORCE" to Reading.INPUT_FORCE,
        )
        assertEquals(known.mapValues { (name, _) -> value(name) }, known)
    }
}
