package dev.ml2sensors.capture

import dev.ml2sensors.source.ImageSample
import dev.ml2sensors.source.InputSample
import dev.ml2sensors.source.LostSamples
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
import kotlin.test.assertEquals
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
            val settings = source.first(StreamTable.worldLeft, values) { (it as ImageSample).settings }
            assertTrue(assertNotNull(settings.exposureNanos) > 0)
            assertNotNull(settings.analogGain)
            assertNotNull(settings.digitalGain)
        }
    }

    @Test
    fun headGazeHandsAndControllerAreTracked() = runBlocking<Unit> {
        for (sensor in ReadingSensor.entries - ReadingSensor.CONTROLLER_INPUT) {
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
}
