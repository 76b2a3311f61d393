package dev.ml2sensors.capture

import dev.ml2sensors.source.Answer
import dev.ml2sensors.source.Condition
import dev.ml2sensors.source.ImageSample
import dev.ml2sensors.source.InputSample
import dev.ml2sensors.source.LostSamples
import dev.ml2sensors.source.MapSample
import dev.ml2sensors.source.MapState
import dev.ml2sensors.source.MarkersSample
import dev.ml2sensors.source.PoseSample
import dev.ml2sensors.source.PosesSample
import dev.ml2sensors.source.Sample
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable
import kotlinx.coroutines.flow.first
import kotlinx.coroutines.runBlocking
import org.junit.jupiter.api.AfterEach
import org.junit.jupiter.api.BeforeEach
import org.junit.jupiter.api.Test
import javax.imageio.ImageIO
import kotlin.test.assertContains
import kotlin.test.assertEquals
import kotlin.test.assertFailsWith
import kotlin.test.assertIs
import kotlin.test.assertNotEquals
import kotlin.test.assertNotNull
import kotlin.test.assertTrue

/** The second way to the sensors: the Khronos loader and the simulated headset's runtime. */
class OpenXrTest {
    @BeforeEach
    fun begin() {
        Simulation.begin()
        NativeLibrary.useOpenXr("libopenxr_loader.so.1", context = null)
    }

    @AfterEach
    fun end(): Unit = Simulation.assertIsLeftAsFound()

    @Test
    fun everyCameraDelivers() = runBlocking<Unit> {
        for (sensor in PixelSensor.entries - PixelSensor.COLOR) {
            NativePixelSource(sensor, NativeBackend.OPENXR).use { source ->
                for (stream in source.streams) {
                    val values = CaptureFixture.values(stream)
                    val (width, height) = source.first(stream, values) { (it as ImageSample).width to it.height }
                    assertEquals(values.width to values.height, width to height, "$stream")
                }
            }
        }
    }

    @Test
    fun theColorCameraDeliversJpegs() = runBlocking<Unit> {
        NativePixelSource(PixelSensor.COLOR, NativeBackend.OPENXR).use { source ->
            val values = StreamValues(stream = 0, width = 640, height = 480, rateHz = 30, format = "jpeg")
            val jpeg = source.first(StreamTable.color, values) { (it as ImageSample).copy() }
            val image = assertNotNull(ImageIO.read(jpeg.inputStream()))
            assertEquals(640 to 480, image.width to image.height)
        }
    }

    @Test
    fun exposureAndGainAreToldAsNoOtherWayDoes() = runBlocking<Unit> {
        NativePixelSource(PixelSensor.WORLD, NativeBackend.OPENXR).use { source ->
            val values = CaptureFixture.values(StreamTable.worldLeft)
            val metadata = source.first(StreamTable.worldLeft, values) { (it as ImageSample).metadata }
            assertTrue(assertNotNull(metadata.exposureNanos) > 0)
            assertNotNull(metadata.analogGain)
            assertNotNull(metadata.digitalGain)
        }
    }

    @Test
    fun headGazeHandsAndControllerAreTracked() = runBlocking<Unit> {
        for (sensor in ReadingSensor.entries -
            setOf(ReadingSensor.CONTROLLER_INPUT, ReadingSensor.MARKERS, ReadingSensor.MAP)) {
            NativeReadingSource(sensor, NativeBackend.OPENXR).use { source ->
                for (stream in source.streams) {
                    source.first(stream, StreamValues()) {
                        if (it is PosesSample) it.poses.size == 26 else (it as PoseSample).pose != null
                    }
                }
            }
        }
    }

    @Test
    fun markersOfTheRoomAreTrackedByTheNamesOfTheirPrograms() = runBlocking<Unit> {
        val kinds = listOf(
            Triple("5X5_100", StreamValues(markerType = "aruco", dictionary = "5X5_100"), Regex("marker_[0-9]+")),
            Triple("36h11", StreamValues(sizeM = 0.48), Regex("tag36h11:[0-9]+")),
            Triple("QR", StreamValues(markerType = "qr"), Regex("qr_[0-9a-f]{8}")),
        )
        for ((tags, values, frames) in kinds) {
            Simulation.configure("tags", tags)
            NativeReadingSource(ReadingSensor.MARKERS, NativeBackend.OPENXR).use { source ->
                val seen = source.samples(StreamTable.markers, values)
                    .first { it is MarkersSample && it.markers.isNotEmpty() } as MarkersSample
                for (it in seen.markers) {
                    assertTrue(frames.matches(it.frame), it.frame)
                    assertEquals(values.sizeM ?: 0.16, it.sizeM, 1e-6)
                }
                assertEquals(seen.markers.size, seen.markers.map { it.frame }.toSet().size)
                if (tags == "QR") assertTrue(seen.markers.all { it.content.startsWith("ml2-") })
            }
        }
        Simulation.configure("tags", "4X4_50")
    }

    @Test
    fun aDictionaryOfAnotherKindOfMarkersIsRefusedWithTheirs() {
        NativeReadingSource(ReadingSensor.MARKERS, NativeBackend.OPENXR).use { source ->
            val answer = source.negotiate(StreamTable.markers, StreamValues(dictionary = "5X5_100"))
            val reason = "dictionary is 5X5_100, expected one of 16h5, 25h9, 36h10, 36h11"
            assertEquals(Answer.Refused(reason), answer)
        }
    }

    @Test
    fun aMapIsAskedForByNameAndFollowed() = runBlocking<Unit> {
        NativeReadingSource(ReadingSensor.MAP, NativeBackend.OPENXR).use { source ->
            var before: MapState? = null
            source.first(StreamTable.map, StreamValues(localize = "Second room")) {
                val sample = it as MapSample
                if (sample.origin == null) before = sample.state
                sample.origin != null && sample.state == SECOND_ROOM
            }
            assertNotEquals(SECOND_ROOM, before, "localized before it was asked for")
        }
    }

    @Test
    fun theGazeSaysThatTheHeadsetFitsAndTheEyesAreCalibrated() = runBlocking<Unit> {
        NativeReadingSource(ReadingSensor.GAZE, NativeBackend.OPENXR).use { source ->
            val expected = Condition(
                true,
                "headset fit is good, eye calibration is fine",
                mapOf("headset_fit" to "good", "eye_calibration" to "fine"),
            )
            source.first(StreamTable.gaze, StreamValues()) { (it as PoseSample).condition == expected }
        }
    }

    @Test
    fun aMapThatIsNotThereIsSaidAndAnUnknownConfidenceRefused() = runBlocking<Unit> {
        NativeReadingSource(ReadingSensor.MAP, NativeBackend.OPENXR).use { source ->
            val failure = assertFailsWith<CaptureException> {
                source.first(StreamTable.map, StreamValues(localize = "Kitchen")) { true }
            }
            assertContains(failure.message.orEmpty(), "not available: map \"Kitchen\"; the headset has 2: ")
            val refused = source.negotiate(StreamTable.map, StreamValues(minConfidence = "best"))
            val reason = "min_confidence is best, expected one of poor, fair, good, excellent"
            assertEquals(reason, assertIs<Answer.Refused>(refused).reason)
        }
    }

    @Test
    fun whatIsPressedOnTheControllerIsRead() = runBlocking<Unit> {
        NativeReadingSource(ReadingSensor.CONTROLLER_INPUT, NativeBackend.OPENXR).use { source ->
            source.first(StreamTable.controllerJoy, StreamValues()) { (it as InputSample).bumper && !it.menu }
            source.first(StreamTable.controllerJoy, StreamValues()) { (it as InputSample).menu && !it.bumper }
        }
    }

    private suspend fun <T> NativeSource.first(stream: StreamSpec, values: StreamValues, read: (Sample) -> T): T {
        lateinit var result: () -> T
        samples(stream, values).first { sample ->
            if (sample is LostSamples) return@first false
            val value = read(sample)
            result = { value }
            value != false
        }
        return result()
    }

    private companion object {
        val SECOND_ROOM = MapState(
            "localized",
            "excellent",
            emptyList(),
            "Second room",
            "28282828-2828-2828-2828-282828282828",
            "on_device",
        )
    }
}
