package dev.ml2sensors.android

import android.graphics.ImageFormat
import android.hardware.camera2.CameraManager
import android.hardware.camera2.CaptureRequest
import android.util.Range
import android.util.Size
import dev.ml2sensors.source.Answer
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.table.StreamTable
import dev.ml2sensors.test
import kotlinx.coroutines.runBlocking
import org.junit.After
import org.junit.Before
import org.junit.Test
import org.junit.runner.RunWith
import org.robolectric.RobolectricTestRunner
import org.robolectric.RuntimeEnvironment
import org.robolectric.annotation.Config
import kotlin.test.assertEquals
import kotlin.test.assertIs

/** Tests the answers of the colour camera, by the tables of Android's own StreamConfigurationMap. */
@RunWith(RobolectricTestRunner::class)
@Config(
    sdk = [29],
    manifest = Config.NONE,
    shadows = [CameraRig.Manager::class, CameraRig.Session::class, CameraRig.Reader::class],
)
class ColorNegotiationTest {
    private val app = RuntimeEnvironment.getApplication()
    private val cameraManager = app.getSystemService(CameraManager::class.java)
    private val rig = CameraRig(cameraManager)
    private var encodeNanosPerPixel = 0.0
    private var nowNanos = 0.0
    private val encoder = JpegEncoder { _, width, height, _ ->
        nowNanos += width * height * encodeNanosPerPixel
        true
    }
    private val speed by lazy { EncoderSpeed(encoder) { nowNanos.toLong() } }
    private val source by lazy {
        Camera2Source(app, { null }, workers = EncoderThreads(2), encoder = encoder, encoderSpeed = speed)
    }
    private val wanted = StreamValues(stream = 0, width = 1920, height = 1080, rateHz = 30, format = "jpeg")

    @Before
    fun loadSlots() = NativeSlots.load()

    @After
    fun close() = source.close()

    @Test
    fun theCamerasOwnJpegIsTakenWhenItHoldsUpNothingAndIsFastEnough() =
        assertFormat(ImageFormat.JPEG, Mode(ImageFormat.JPEG, HD, FRAME_30))

    @Test
    fun theCameraThatIsAskedForServes() {
        val modes = listOf(Mode(ImageFormat.JPEG, HD, FRAME_30))
        rig.add("0", modes)
        rig.add("1", listOf(Mode(ImageFormat.JPEG, HD, FRAME_15)))
        val zero = wanted.copy(cameraId = 0)
        assertEquals(Answer.Applied(zero), source.negotiate(StreamTable.color, zero))
        val one = assertIs<Answer.Adjusted>(source.negotiate(StreamTable.color, wanted.copy(cameraId = 1)))
        assertEquals(1 to 15, one.values.cameraId to one.values.rateHz)
    }

    @Test
    fun theOtherCameraServesWhereTheOneAskedForIsNotListedAndTheAnswerSaysSo() {
        rig.add("0", listOf(Mode(ImageFormat.JPEG, HD, FRAME_15)))
        val answer = assertIs<Answer.Adjusted>(source.negotiate(StreamTable.color, wanted.copy(cameraId = 1)))
        assertEquals(wanted.copy(cameraId = 0, rateHz = 15), answer.values)
        assertEquals(
            "this headset lists no camera 1; camera 0 serves instead; camera 0 makes 15.0 images of 1920x1080 per " +
                "second at most, and exposes at 15, 30, 60 Hz",
            answer.reason,
        )
    }

    @Test
    fun aJpegThatStallsTheCameraIsMadeHereInstead() =
        assertFormat(ImageFormat.YUV_420_888, Mode(ImageFormat.JPEG, HD, FRAME_30, stallNanos = 1))

    @Test
    fun aJpegThatIsTooSlowIsMadeHereInstead() =
        assertFormat(ImageFormat.YUV_420_888, Mode(ImageFormat.JPEG, HD, FRAME_15))

    @Test
    fun aRateThatTheCameraDoesNotReachIsAdjustedToOneThatItDoes() {
        rig.add("1", listOf(Mode(ImageFormat.YUV_420_888, HD, FRAME_30)))
        val answer = assertIs<Answer.Adjusted>(source.negotiate(StreamTable.color, wanted.copy(rateHz = 60)))
        assertEquals(wanted, answer.values)
        val expected = "camera 1 makes 30.0 images of 1920x1080 per second at most, and exposes at 15, 30, 60 Hz"
        assertEquals(expected, answer.reason)
    }

    @Test
    fun aRateThatTheEncoderDoesNotReachIsAdjusted() {
        rig.add("1", listOf(Mode(ImageFormat.YUV_420_888, HD, FRAME_30)))
        // Two workers at 100 ms per image
        encodeNanosPerPixel = 0.1e9 / (1920 * 1080)
        val answer = assertIs<Answer.Adjusted>(source.negotiate(StreamTable.color, wanted))
        assertEquals(15, answer.values.rateHz)
        val expected = "camera 1 makes 20.0 images of 1920x1080 per second at most, and exposes at 15, 30, 60 Hz"
        assertEquals(expected, answer.reason)
    }

    @Test
    fun theLeastRateIsSaidNotToBeReachedWhenItIsNot() {
        rig.add("1", listOf(Mode(ImageFormat.YUV_420_888, HD, 1_000_000_000)))
        val answer = assertIs<Answer.Adjusted>(source.negotiate(StreamTable.color, wanted.copy(rateHz = 15)))
        assertEquals(15, answer.values.rateHz)
        assertEquals("camera 1 makes 1.0 images", answer.reason.substringBefore(" of"))
    }

    @Test
    fun aRateThatAutomaticExposureDoesNotOfferIsAdjusted() {
        rig.add("1", listOf(Mode(ImageFormat.YUV_420_888, HD, FRAME_30 / 2)), fps = listOf(5 to 15, 15 to 60))
        assertEquals(15, assertIs<Answer.Adjusted>(source.negotiate(StreamTable.color, wanted)).values.rateHz)
    }

    @Test
    fun theSteadiestRangeOfTheRateIsAskedFor() = runBlocking {
        rig.add("1", listOf(Mode(ImageFormat.JPEG, HD, FRAME_30)), fps = listOf(15 to 30, 24 to 30, 7 to 30, 60 to 60))
        source.samples(StreamTable.color, wanted).test {
            val request = rig.awaitRunning().request
            assertEquals(Range(24, 30), request.get(CaptureRequest.CONTROL_AE_TARGET_FPS_RANGE))
            cancel()
        }
    }

    @Test
    fun aSizeThatTheCameraLacksIsRefusedWithThoseItHas() {
        rig.add("1", listOf(Mode(ImageFormat.YUV_420_888, Size(640, 480), FRAME_30)))
        val expected = "camera 1 has no images of 1920x1080; it has: 640x480"
        assertEquals(Answer.Refused(expected), source.negotiate(StreamTable.color, wanted))
    }

    @Test
    fun aCameraThatIsNotListedIsRefusedWithThoseThatAre() {
        rig.add("0", listOf(Mode(ImageFormat.YUV_420_888, HD, FRAME_30)))
        val mixedReality = StreamValues(stream = 1, width = 960, height = 720, rateHz = 30, format = "jpeg")
        val expected = "this headset lists no camera 3; it lists: 0"
        assertEquals(Answer.Refused(expected), source.negotiate(StreamTable.mixedReality, mixedReality))
    }

    @Test
    fun camera0ServesColorWhereThereIsNoCamera1() = runBlocking {
        rig.add("0", listOf(Mode(ImageFormat.JPEG, HD, FRAME_30)))
        source.samples(StreamTable.color, wanted).test {
            assertEquals("ml2s-camera-0", rig.awaitRunning().handler.looper.thread.name)
            cancel()
        }
    }

    @Test
    fun valuesThatTheTableDoesNotHaveAreRefused() {
        val answer = source.negotiate(StreamTable.color, wanted.copy(rateHz = 25))
        assertEquals(Answer.Refused("update_rate is 25, expected one of 15, 30, 60"), answer)
    }

    /** Asserts that images run in [expected] if the camera makes JPEGs as [jpeg] says, and raw ones at 30 Hz. */
    private fun assertFormat(expected: Int, jpeg: Mode) = runBlocking {
        rig.add("1", listOf(jpeg, Mode(ImageFormat.YUV_420_888, HD, FRAME_30)))
        assertEquals(Answer.Applied(wanted), source.negotiate(StreamTable.color, wanted))
        source.samples(StreamTable.color, wanted).test {
            rig.awaitRunning()
            assertEquals(expected, CameraRig.readers.single().reader.imageFormat)
            cancel()
        }
    }

    private companion object {
        val HD = Size(1920, 1080)
        const val FRAME_30 = 33_333_333L
        const val FRAME_15 = 66_666_666L
    }
}
