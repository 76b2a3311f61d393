package dev.ml2sensors.android

import android.graphics.ImageFormat
import android.hardware.camera2.CameraAccessException
import android.hardware.camera2.CameraCharacteristics
import android.hardware.camera2.CameraDevice
import android.hardware.camera2.CameraManager
import android.hardware.camera2.CaptureRequest
import android.util.Range
import android.util.Size
import app.cash.turbine.Event
import app.cash.turbine.ReceiveTurbine
import dev.ml2sensors.source.Answer
import dev.ml2sensors.source.ClockDomain
import dev.ml2sensors.source.Distortion
import dev.ml2sensors.source.DropReason
import dev.ml2sensors.source.ImageSample
import dev.ml2sensors.source.Intrinsics
import dev.ml2sensors.source.LostSamples
import dev.ml2sensors.source.Sample
import dev.ml2sensors.source.SourceException
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable
import dev.ml2sensors.test
import kotlinx.coroutines.flow.Flow
import kotlinx.coroutines.flow.MutableStateFlow
import kotlinx.coroutines.flow.map
import kotlinx.coroutines.flow.onEach
import kotlinx.coroutines.flow.retry
import kotlinx.coroutines.flow.take
import kotlinx.coroutines.flow.toList
import kotlinx.coroutines.runBlocking
import kotlinx.coroutines.yield
import org.junit.After
import org.junit.Before
import org.junit.Test
import org.junit.runner.RunWith
import org.robolectric.RobolectricTestRunner
import org.robolectric.RuntimeEnvironment
import org.robolectric.annotation.Config
import org.robolectric.shadows.ShadowLog
import kotlin.random.Random
import kotlin.test.assertContentEquals
import kotlin.test.assertEquals
import kotlin.test.assertIs
import kotlin.test.assertNull
import kotlin.test.assertTrue

/** On Android 10's own Camera2, with cameras below it. */
@RunWith(RobolectricTestRunner::class)
@Config(
    sdk = [29],
    manifest = Config.NONE,
    shadows = [
        CameraRig.Manager::class, CameraRig.Session::class, CameraRig.Reader::class,
        CameraRig.TaggedResult::class, CameraRig.TaggedTotalResult::class, CameraRig.Device::class,
    ],
)
class Camera2SourceTest {
    private class Copied(val image: ImageSample, val bytes: ByteArray) {
        val chroma = image.plane(ImageSample.CHROMA)?.let { pixels -> ByteArray(pixels.remaining()).also(pixels::get) }
    }

    private val app = RuntimeEnvironment.getApplication()
    private val cameraManager = app.getSystemService(CameraManager::class.java)
    private val rig = CameraRig(cameraManager)
    private val device = SettableClocks(monotonicNanos = 500 * SECOND, suspendedNanos = 7_000 * SECOND)
    private val bases = MutableStateFlow<Map<StreamSpec, ClockDomain>>(emptyMap())
    private val poses = FakePoses()
    private val encoder = FakeEncoder()
    private val source = Camera2Source(app, poses, device.clocks, bases, EncoderThreads(WORKERS), encoder)
    private val values = StreamValues(stream = 0, width = 640, height = 480, rateHz = 30, format = "jpeg")

    @Before
    fun loadSlots() = NativeSlots.load()

    @After
    fun close() {
        source.close()
        assertEquals(emptyList(), CameraRig.readers, "every reader is closed")
        assertEquals(0, NativeSlots.mappedBytes, "every image was given back")
        CameraRig.failure = null
        CameraRig.failures.clear()
    }

    @Test
    fun aJpegOfTheCameraIsCopiedAndGoesWithItsResult() = withCamera { camera ->
        val timestamp = device.monotonicNanos - 20_000_000
        assertEquals(Range(30, 30), camera.request.get(CaptureRequest.CONTROL_AE_TARGET_FPS_RANGE))
        val image = FakeImage.jpeg(timestamp, byteArrayOf(1, 2, 3))
        with(rig) { camera.image(image) }
        assertTrue(image.isClosed, "as soon as it is copied")
        with(rig) { camera.result(timestamp, exposureNanos = 8_000_000) }
        val sample = awaitImage()
        assertContentEquals(byteArrayOf(1, 2, 3), sample.bytes)
        assertEquals(listOf(640, 480, 0), sample.image.run { listOf(width, height, strideBytes) })
        assertEquals(8_000_000, sample.image.metadata.exposureNanos)
        assertNull(sample.image.metadata.analogGain)
    }

    @Test
    fun withTheVendorsTagsTimePoseAndIntrinsicsAreThoseOfTheCentreOfExposure() {
        withPoses { camera ->
            val floats = floatArrayOf(1280f, 960f, 901f, 902f, 641f, 481f, 70f, .1f, .2f, .3f, .4f, .5f)
            val tags = mapOf(
                "com.amd.control.cvip_timestamps" to longArrayOf(100, 200, 300, 400),
                "com.amd.control.intrinsics" to FloatArray(12) { 9f } + floats,
            )
            camera.capture(tags)
            val sample = awaitImage().image
            assertEquals(200 + FakePoses.ML_TIME_IN_BOOT_TIME, sample.captureNanos)
            assertEquals(FakePoses.poseAt(200), sample.pose)
            val lens = Distortion.PlumbBob(
                .1f.toDouble(),
                .2f.toDouble(),
                .3f.toDouble(),
                .4f.toDouble(),
                .5f.toDouble(),
            )
            assertEquals(Intrinsics(640, 480, 450.5, 451.0, 320.5, 240.5, lens), sample.intrinsics)
        }
        assertEquals(setOf("ml2s-camera-1"), poses.threads.toSet(), "one thread for the tracker's life")
        assertEquals(listOf("open", "capture", "pose", "close"), poses.calls)
    }

    @Test
    fun aPoseThatCannotBeHadCostsThePoseAlone() = runBlocking {
        rig.add("1", listOf(JPEG))
        for (failing in listOf("open", "capture", "pose")) {
            poses.failing = failing
            val sample = imageAt(centreNanos = 200)
            assertNull(sample.pose, failing)
            val isCentre = failing == "pose"
            val expected = if (isCentre) "exposure_centre" else "sensor_timestamp"
            assertEquals(expected, sample.metadata.stampSource, failing)
            val captureNanos = if (isCentre) 200 + FakePoses.ML_TIME_IN_BOOT_TIME else device.bootNanos
            assertEquals(captureNanos, sample.captureNanos, failing)
        }
    }

    @Test
    fun aCentreOfExposureOfZeroIsNone() = runBlocking {
        rig.add("1", listOf(JPEG))
        val sample = imageAt(centreNanos = 0)
        assertEquals(device.bootNanos to "sensor_timestamp", sample.captureNanos to sample.metadata.stampSource)
        assertNull(sample.pose)
    }

    /** The sample of an image that begins now, by the vendor's tags exposed around [centreNanos]. */
    private suspend fun imageAt(centreNanos: Long): ImageSample {
        poses.isThere = true
        lateinit var sample: ImageSample
        copies().test {
            val camera = rig.awaitRunning()
            val tags = mapOf("com.amd.control.cvip_timestamps" to longArrayOf(0, centreNanos, 0, 0))
            camera.capture(tags)
            sample = awaitImage().image
            cancel()
        }
        return sample
    }

    @Test
    fun aShapeWithoutIntrinsicsHasNone() = withCamera { camera ->
        val wide = floatArrayOf(1920f, 1080f, 1f, 1f, 1f, 1f, 1f, 1f, 1f, 1f, 1f, 1f)
        camera.capture(mapOf("com.amd.control.intrinsics" to wide))
        assertNull(awaitImage().image.intrinsics)
    }

    @Test
    fun numbersOfTheVendorThatNoLensHasAreNoIntrinsics() = withCamera { camera ->
        val lens = floatArrayOf(1280f, 960f, 901f, 902f, 641f, 481f, 70f, .1f, .2f, .3f, .4f, .5f)
        val zeros = FloatArray(24)
        fun changed(index: Int, value: Float) = lens.copyOf().also { it[index] = value }
        val odd = (0..11).flatMap { listOf(changed(it, Float.NaN), changed(it, Float.POSITIVE_INFINITY)) } +
            (0..3).flatMap { listOf(changed(it, 0f), changed(it, -1f)) } + changed(0, 1e9f) + changed(9, 1e30f) + zeros
        for ((index, numbers) in (odd + listOf(lens + zeros, zeros + lens)).withIndex()) {
            device.monotonicNanos += SECOND
            camera.capture(mapOf("com.amd.control.intrinsics" to numbers))
            val found = awaitImage().image.intrinsics
            assertEquals(if (index < odd.size) null else 450.5, found?.fx, numbers.joinToString())
        }
        val said = ShadowLog.getLogsForTag("ml2s").filter { "com.amd.control.intrinsics" in it.msg }
        assertEquals(1, said.size, "$said")
    }

    @Test
    fun tagsOfAnotherTypeOrLengthThanTheVendorDocumentsAreNone() = withCamera { camera ->
        val noFloats =
            listOf(DoubleArray(12) { 1.0 }, IntArray(12) { 1 }, "text", floatArrayOf(), FloatArray(11) { 1f })
        val noTimes = listOf(IntArray(4) { 1 }, 7L, longArrayOf(), longArrayOf(1), longArrayOf(1, -1, 1, 1))
        // As Camera2 says that a tag has another type
        val unreadable = List(5) { UnsupportedOperationException("no marshaler") }
        for ((floats, times) in noFloats.zip(noTimes) + unreadable.zip(unreadable)) {
            device.monotonicNanos += SECOND
            camera.capture(mapOf("com.amd.control.intrinsics" to floats, "com.amd.control.cvip_timestamps" to times))
            val image = awaitImage().image
            assertNull(image.intrinsics)
            assertEquals(device.bootNanos to "sensor_timestamp", image.captureNanos to image.metadata.stampSource)
        }
        val said = ShadowLog.getLogsForTag("ml2s").map { it.msg.substringBefore(':') }
        assertEquals(listOf("com.amd.control.cvip_timestamps", "com.amd.control.intrinsics"), said.sorted())
    }

    @Test
    fun anExposureThatNoCameraHasIsNone() = withCamera { camera ->
        for (exposureNanos in listOf(-1, 0, Long.MAX_VALUE, Long.MIN_VALUE)) {
            device.monotonicNanos += SECOND
            with(rig) {
                camera.image(FakeImage.jpeg(device.monotonicNanos, byteArrayOf(1)))
                camera.result(device.monotonicNanos, exposureNanos)
            }
            val image = awaitImage().image
            assertEquals(device.bootNanos to null, image.captureNanos to image.metadata.exposureNanos)
        }
    }

    @Test
    fun aCameraThatIsFasterThanAskedIsThinned() = withCamera { camera ->
        val period = SECOND / 60
        repeat(60) {
            device.monotonicNanos += period
            camera.capture(FakeImage.jpeg(device.monotonicNanos, byteArrayOf(1)))
        }
        camera.fail(wasImageCaptured = false)
        val times = mutableListOf<Long>()
        while (true) (awaitItem() as? Copied ?: break).let { times += it.image.captureNanos }
        val pauses = times.zipWithNext { before, next -> next - before }
        assertTrue(pauses.drop(9).all { it in 2 * period - 10..2 * period + 10 }, "$pauses")
        cancelAndIgnoreRemainingEvents() // what was copied last may come after the loss
    }

    @Test
    fun theVendorsTagsOfARequestAreThoseOfItsCamera() = withCamera { camera ->
        assertEquals(1.toByte(), camera.request.get(byteTag("com.amd.control.forceapply")))
    }

    private fun byteTag(name: String) = CaptureRequest.Key(name, Byte::class.java)

    @Test
    fun withoutTheVendorsTagsTheTimeIsThatOfCamera2AndNothingIsInvented() {
        withPoses { camera ->
            with(rig) {
                camera.image(FakeImage.jpeg(device.monotonicNanos - 20_000_000, byteArrayOf(1)))
                camera.result(device.monotonicNanos - 20_000_000, exposureNanos = 8_000_000)
            }
            val sample = awaitImage().image
            assertEquals(device.bootNanos - 20_000_000 + 4_000_000, sample.captureNanos)
            assertNull(sample.pose)
            assertNull(sample.intrinsics)
        }
        assertEquals(ClockDomain.MONOTONIC, bases.value[StreamTable.color])
    }

    @Test
    fun timestampsThatAndroidPromisesToBeBootTimeAreTakenAsSuch() = runBlocking {
        rig.add("1", listOf(JPEG), timestampSource = CameraCharacteristics.SENSOR_INFO_TIMESTAMP_SOURCE_REALTIME)
        copies().test {
            val camera = rig.awaitRunning()
            with(rig) {
                camera.image(FakeImage.jpeg(device.bootNanos, byteArrayOf(1)))
                camera.result(device.bootNanos)
            }
            assertEquals(device.bootNanos, awaitImage().image.captureNanos)
            with(rig) {
                camera.image(FakeImage.jpeg(0, byteArrayOf(1)))
                camera.result(0)
            }
            assertLost(DropReason.SOURCE_LATE)
            cancel()
        }
    }

    @Test
    fun mixedRealityIsCamera3WithTagsOfItsOwn() = runBlocking {
        rig.add("3", listOf(Mode(ImageFormat.JPEG, Size(960, 720), 33_333_333)))
        poses.isThere = true
        copies(StreamTable.mixedReality, values.copy(stream = 1, width = 960, height = 720)).test {
            val camera = rig.awaitRunning()
            assertEquals(0.toByte(), camera.request.get(byteTag("com.ml.control.capture_mode")))
            val times = longArrayOf(1, 2, 3, 4)
            camera.capture(mapOf("com.ml.control.cvip_timestamps" to times))
            assertEquals(2 + FakePoses.ML_TIME_IN_BOOT_TIME, awaitImage().image.captureNanos)
            cancel()
        }
    }

    @Test
    fun yuvImagesAreCopiedWhateverTheirStridesAndDeliveredInOrderOfCapture() = withCamera(YUV) { camera ->
        val random = Random(3)
        val pictures = List(WORKERS) { Picture(640, 480, random) }
        // The first is ready last
        encoder.hold(pictures.first().toNv21())
        pictures.forEachIndexed { i, picture -> camera.capture(picture.image(device.monotonicNanos + i, random)) }
        encoder.awaitDone(WORKERS - 1)
        encoder.letGo()
        for ((i, picture) in pictures.withIndex()) {
            val sample = awaitImage()
            assertEquals(i.toLong(), sample.image.frameNumber)
            assertContentEquals(FakeEncoder.jpegOf(picture.toNv21()), sample.bytes)
        }
    }

    @Test
    fun imagesForVideoStayRawAndTheSlowerEncoderOfJpegsDoesNotMatter() = runBlocking {
        rig.add("1", listOf(Mode(ImageFormat.YUV_420_888, VGA, minNanos = 16_666_666)))
        val random = Random(5)
        val picture = Picture(640, 480, random)
        val video = values.copy(format = StreamValues.H264, rateHz = 60)
        assertEquals(Answer.Applied(video), source.negotiate(StreamTable.color, video))
        copies(values = video).test {
            val camera = rig.awaitRunning()
            camera.capture(picture.image(device.monotonicNanos, random))
            val sample = awaitImage()
            assertContentEquals(picture.y, sample.bytes)
            assertEquals(640, sample.image.strideBytes)
            assertContentEquals(picture.toNv21().copyOfRange(640 * 480, 640 * 480 * 3 / 2), sample.chroma)
            cancel()
        }
    }

    @Test
    fun whatABusyEncoderCannotTakeIsCountedAndTheCameraGoesOn() = withCamera(YUV) { camera ->
        val random = Random(4)
        val picture = Picture(640, 480, random)
        encoder.hold(picture.toNv21())
        val images = List(WORKERS + 1 + 5) { picture.image(device.monotonicNanos + it, random) }
        images.forEach { camera.capture(it) }
        assertTrue(images.all { it.isClosed })
        encoder.letGo()
        var encoded = 0
        var lost = 0
        while (encoded + lost < images.size) {
            val sample = awaitItem()
            if (sample is LostSamples) assertEquals(DropReason.ENCODER_BUSY, sample.reason)
            if (sample is LostSamples) lost += sample.count else encoded++
        }
        assertEquals(5, lost)
    }

    @Test
    fun imagesThatAreKeptTakeNoMemoryFromTheCameraButSlots() = runBlocking {
        rig.add("1", listOf(JPEG))
        val kept = mutableListOf<ImageSample>()
        source.samples(StreamTable.color, values).onEach { if (it is ImageSample) kept += it.apply { retain() } }.test {
            val camera = rig.awaitRunning()
            repeat(8) {
                camera.capture(FakeImage.jpeg(device.monotonicNanos + it, byteArrayOf(it.toByte())))
                awaitItem()
            }
            camera.capture(FakeImage.jpeg(device.monotonicNanos + 8, byteArrayOf(8)))
            assertEquals(DropReason.NO_BUFFER, assertIs<LostSamples>(awaitItem()).reason)
            assertEquals((0..7).toList(), kept.map { it.copy().single().toInt() }, "what is kept is not written over")
            assertEquals(8L * 640 * 480, NativeSlots.mappedBytes, "outside of the heap")
            kept.forEach(ImageSample::release)
            camera.capture(FakeImage.jpeg(device.monotonicNanos + 9, byteArrayOf(9)))
            assertIs<ImageSample>(awaitItem()).release()
            cancel()
        }
    }

    @Test
    fun aJpegThatDoesNotFitIsLostAndCounted() = withCamera { camera ->
        camera.capture(FakeImage.jpeg(device.monotonicNanos, ByteArray(640 * 480 + 1)))
        assertEquals(DropReason.NO_BUFFER, assertIs<LostSamples>(awaitItem()).reason)
    }

    @Test
    fun anImageWithoutAResultIsLostAndCounted() = withCamera { camera ->
        with(rig) { camera.image(FakeImage.jpeg(device.monotonicNanos - 1, byteArrayOf(1))) }
        camera.capture(FakeImage.jpeg(device.monotonicNanos, byteArrayOf(2)))
        assertEquals(DropReason.SOURCE_LATE, assertIs<LostSamples>(awaitItem()).reason)
        assertContentEquals(byteArrayOf(2), awaitImage().bytes)
    }

    @Test
    fun aCameraThatIsTakenAwayFailsItsFlowAndIsClosed() = untilItEnds {
        CameraRig.opened.disconnect()
        val expected = "camera 1 was taken away: another use has priority, or the app is not in front"
        assertEquals(expected, assertIs<SourceException>(awaitError()).message)
    }

    @Test
    fun anErrorOfTheCameraFailsItsFlowWithItsName() = untilItEnds {
        CameraRig.opened.fail(CameraDevice.StateCallback.ERROR_CAMERA_SERVICE)
        val expected = "camera 1 failed: error of the camera service"
        assertEquals(expected, assertIs<SourceException>(awaitError()).message)
    }

    @Test
    fun aCameraThatCannotBeOpenedFailsItsFlow() = runBlocking {
        rig.add("1", listOf(JPEG))
        CameraRig.failure = CameraAccessException(CameraAccessException.CAMERA_IN_USE)
        source.samples(StreamTable.color, values).test {
            val failure = assertIs<SourceException>(awaitError())
            assertEquals("camera 1 cannot be used: The camera device is in use already", failure.message)
        }
    }

    @Test
    fun aCameraThatFailsInAnyStateFailsItsFlowAndIsUsedAgain() = runBlocking {
        rig.add("1", listOf(JPEG))
        for (error in listOf(CameraRig.DISCONNECTED) + (1..6)) {
            CameraRig.openError = error
            assertFails("camera 1 ")
            CameraRig.openError = null
            CameraRig.holdsSessions = true
            assertFails("camera 1 ") {
                while (!CameraRig.isSessionHeld) yield()
                CameraRig.opened.end(error)
            }
            rig.answerSessions()
            CameraRig.holdsClosings = true
            copies().test {
                rig.awaitRunning()
                cancel()
            }
            repeat(2) { CameraRig.opened.end(error) }
            rig.answerClosings()
            assertIsUsedAgain()
        }
    }

    private fun CameraRig.Opened.end(error: Int) = if (error == CameraRig.DISCONNECTED) disconnect() else fail(error)

    /** Asserts that a flow fails as said, while [meanwhile] runs. */
    private suspend fun assertFails(expected: String, meanwhile: suspend () -> Unit = {}) =
        source.samples(StreamTable.color, values).test {
            meanwhile()
            val failure = assertIs<SourceException>(awaitError())
            assertTrue(failure.message.orEmpty().startsWith(expected), "$failure")
        }

    @Test
    fun whateverACallOfCamera2ThrowsItsFlowFailsWithATypeAndTheCameraIsUsedAgain() = runBlocking {
        rig.add("1", listOf(JPEG))
        val thrown = listOf(
            CameraAccessException(CameraAccessException.CAMERA_ERROR),
            IllegalStateException("CameraDevice was already closed"),
            UnsupportedOperationException("no"),
            NullPointerException(null),
        )
        for (cause in thrown) {
            for (call in listOf("CameraManager.getCameraIdList", "CameraManager.getCameraCharacteristics")) {
                CameraRig.failures[call] = cause
                assertFails("Android cannot describe its cameras: ")
                assertIs<Answer.Refused>(source.negotiate(StreamTable.color, values), "$call: $cause")
                CameraRig.failures.clear()
            }
            val calls = listOf(
                "CameraManager.openCamera",
                "CameraDevice.createCaptureSession",
                "CameraDevice.createCaptureRequest",
                "CameraCaptureSession.setRepeatingRequest",
            )
            for (call in calls) {
                CameraRig.failures[call] = cause
                assertFails("camera 1 cannot be used: ")
                CameraRig.failures.clear()
            }
            if (cause is RuntimeException) CameraRig.failures["CameraDevice.close"] = cause
            copies().test {
                rig.awaitRunning()
                cancel()
            }
            CameraRig.failures.clear()
            assertIsUsedAgain()
        }
    }

    @Test
    fun aFailureOnTheThreadOfTheCameraEndsTheFlowInsteadOfTheApp() = untilItEnds { camera ->
        val timestampOfNoClock = 42L
        repeat(100) { camera.capture(FakeImage.jpeg(timestampOfNoClock + it, byteArrayOf(1))) }
        assertIs<SourceException>(awaitLossesAndError().second)
    }

    @Test
    fun anImageThatCannotBeReadIsLostAndEndsNothing() = withCamera { camera ->
        camera.capture(unreadable(0))
        assertLost(DropReason.UNUSABLE)
        camera.capture(FakeImage.jpeg(device.monotonicNanos, byteArrayOf(1)))
        awaitImage()
    }

    @Test
    fun imagesThatCannotBeReadEndTheFlowAfterThirtyInARow() = untilItEnds { camera ->
        repeat(29) { camera.capture(unreadable(it)) }
        camera.capture(FakeImage.jpeg(device.monotonicNanos + 29, byteArrayOf(1)))
        while (awaitItem() !is ImageSample) Unit
        repeat(30) { camera.capture(unreadable(30 + it)) }
        val (lost, failure) = awaitLossesAndError()
        assertEquals(mapOf(DropReason.UNUSABLE to 30), lost, "the image that ends the flow is counted, too")
        assertIs<IllegalArgumentException>(failure)
    }

    @Test
    fun framesInFlightWhenACameraFailsAreDeliveredOrCounted() = untilItEnds(YUV) { camera ->
        val random = Random(7)
        val pictures = List(2) { Picture(640, 480, random) }
        encoder.hold(pictures.first().toNv21())
        pictures.forEachIndexed { i, picture -> camera.capture(picture.image(device.monotonicNanos + i, random)) }
        encoder.awaitDone(1)
        with(rig) { camera.image(pictures.first().image(device.monotonicNanos + 2, random)) }
        CameraRig.opened.disconnect()
        while (!CameraRig.opened.isClosed) yield()
        encoder.letGo()
        val images = mutableListOf<Long>()
        val (lost) = awaitLossesAndError { images += it.frameNumber }
        assertEquals(listOf(0L, 1L), images)
        assertEquals(mapOf(DropReason.SOURCE_LATE to 1), lost, "one has no result")
    }

    /** An image with three planes, where a JPEG has one. */
    private fun unreadable(number: Int) = Picture(640, 480, Random(1)).image(device.monotonicNanos + number, Random(2))

    @Test
    fun capturesAndBuffersThatTheCameraLosesAreCounted() = withCamera { camera ->
        camera.fail(wasImageCaptured = false)
        assertLost(DropReason.UNUSABLE)
        camera.loseBuffer()
        assertLost(DropReason.UNUSABLE)
        camera.fail(wasImageCaptured = true)
        with(rig) { camera.image(FakeImage.jpeg(device.monotonicNanos - 1, byteArrayOf(1))) }
        camera.capture(FakeImage.jpeg(device.monotonicNanos, byteArrayOf(2)))
        assertLost(DropReason.SOURCE_LATE)
        assertContentEquals(byteArrayOf(2), awaitImage().bytes)
    }

    private suspend fun ReceiveTurbine<Any>.assertLost(reason: DropReason) =
        assertIs<LostSamples>(awaitItem()).let { assertEquals(1 to reason, it.count to it.reason) }

    @Test
    fun aTrackerThatFailsIsOpenedAgain() {
        withPoses { camera ->
            suspend fun next(): ImageSample {
                device.monotonicNanos += SECOND / 30
                camera.capture(CENTRE)
                return awaitImage().image
            }
            assertEquals(FakePoses.poseAt(200), next().pose)
            poses.failing = "pose"
            assertNull(next().pose)
            poses.failing = null
            assertNull(next().pose, "not asked again yet")
            device.monotonicNanos += SECOND
            assertEquals(FakePoses.poseAt(200), next().pose)
        }
        assertEquals(listOf("open", "close", "open", "close"), poses.calls.filter { it == "open" || it == "close" })
    }

    @Test
    fun anEncoderThatFailsCostsImagesAndEndsTheFlowAfterThirtyInARow() = untilItEnds(YUV) { camera ->
        encoder.fails = true
        repeat(29) {
            camera.capture(Picture(640, 480, Random(5)).image(device.monotonicNanos + it, Random(6)))
            assertEquals(DropReason.UNUSABLE, assertIs<LostSamples>(awaitItem()).reason)
        }
        camera.capture(Picture(640, 480, Random(5)).image(device.monotonicNanos + 29, Random(6)))
        val (lost, failure) = awaitLossesAndError()
        assertEquals(mapOf(DropReason.UNUSABLE to 1), lost, "the image that ends the flow is counted, too")
        assertEquals("Android failed to encode a JPEG", assertIs<SourceException>(failure).message)
    }

    @Test
    fun theEndOfTheCollectorClosesTheCameraAndItsThread() = runBlocking {
        rig.add("1", listOf(JPEG))
        lateinit var thread: Thread
        copies().take(1).test {
            val camera = rig.awaitRunning()
            thread = camera.handler.looper.thread
            assertEquals("ml2s-camera-1", thread.name)
            camera.capture(FakeImage.jpeg(device.monotonicNanos, byteArrayOf(1)))
            awaitImage()
            awaitComplete()
        }
        assertTrue(CameraRig.opened.isClosed)
        thread.join()
    }

    @Test
    fun aPausedSourceClosesTheCameraAndTheFlowGoesOnAfterwards() = withCamera {
        val first = CameraRig.opened
        source.pause()
        while (!first.isClosed) yield()
        source.resume()
        rig.awaitRunning().capture(FakeImage.jpeg(device.monotonicNanos, byteArrayOf(2)))
        assertContentEquals(byteArrayOf(2), awaitImage().bytes)
    }

    @Test
    fun closingTheSourceEndsItsFlows() = untilItEnds {
        source.close()
        awaitComplete()
        assertEquals(emptyList(), source.samples(StreamTable.color, values).toList())
    }

    @Test
    fun aCameraThatNeverSaysThatItIsClosedKeepsNoCollectorAndIsUsedAgainWhenItDoes() = runBlocking {
        rig.add("1", listOf(JPEG))
        CameraRig.holdsClosings = true
        copies().test {
            rig.awaitRunning()
            cancel()
        }
        assertIsStuck()
        rig.answerClosings()
        assertIsUsedAgain()
    }

    @Test
    fun aCameraThatDoesNotSayItsEndEndsTheFlowsOfAClosedSource() = runBlocking {
        rig.add("1", listOf(JPEG))
        CameraRig.holdsClosings = true
        source.samples(StreamTable.color, values).test {
            rig.awaitRunning()
            source.close()
            assertTrue(
                "the last run of camera 1 has not ended" in assertIs<SourceException>(awaitError()).message.orEmpty(),
            )
        }
        rig.answerClosings()
        while (CameraRig.readers.isNotEmpty()) yield()
    }

    @Test
    fun aCameraThatIsTakenAwayAndNeverClosesKeepsItsFirstReason() = runBlocking {
        rig.add("1", listOf(JPEG))
        CameraRig.holdsClosings = true
        source.samples(StreamTable.color, values).test {
            rig.awaitRunning()
            CameraRig.opened.disconnect()
            assertNamesFirstReason(awaitError())
        }
        repeat(2) { source.samples(StreamTable.color, values).test { assertNamesFirstReason(awaitError()) } }
        rig.answerClosings()
        assertIsUsedAgain()
    }

    private fun assertNamesFirstReason(failure: Throwable) {
        val message = assertIs<SourceException>(failure).message.orEmpty()
        assertTrue(message.startsWith("camera 1 was taken away: "), message)
        assertTrue("; the last run of camera 1 has not ended" in message, message)
    }

    @Test
    fun aCameraThatNeverOpensKeepsNoCollectorAndIsClosedWhenItDoes() = runBlocking {
        rig.add("1", listOf(JPEG))
        CameraRig.holdsOpenings = true
        copies().test {
            while (!CameraRig.isOpeningHeld) yield()
            cancel()
        }
        assertIsStuck()
        rig.answerOpenings()
        while (CameraRig.readers.isNotEmpty()) yield()
        assertTrue(CameraRig.opened.isClosed)
        assertIsUsedAgain()
    }

    @Test
    fun callsOfTheCameraServiceThatDoNotReturnKeepNoCollector() = runBlocking {
        rig.add("1", listOf(JPEG))
        val opened = NeverReturns.hold("CameraManager.openCamera")
        copies().test {
            while (CameraRig.readers.isEmpty()) yield()
            cancel()
        }
        assertIsStuck()
        opened()
        while (CameraRig.readers.isNotEmpty() || hasCameraThread()) yield()
        val closed = NeverReturns.hold("CameraDevice.close")
        copies().test {
            rig.awaitRunning()
            cancel()
        }
        assertIsStuck()
        closed()
        assertIsUsedAgain()
    }

    private fun hasCameraThread() = Thread.getAllStackTraces().keys.any { it.name.startsWith("ml2s-camera") }

    private suspend fun assertIsStuck() = source.samples(StreamTable.color, values).test {
        val expected = "the last run of camera 1 has not ended"
        assertTrue(expected in assertIs<SourceException>(awaitError()).message.orEmpty())
    }

    private suspend fun assertIsUsedAgain() {
        while (CameraRig.readers.isNotEmpty() || hasCameraThread()) yield()
        while (rig.nextRunning() != null) Unit
        // The run ends a little after its thread
        copies().retry { "has not ended" in it.message.orEmpty() }.test {
            rig.awaitRunning().capture(FakeImage.jpeg(device.monotonicNanos, byteArrayOf(1)))
            awaitImage()
            cancel()
        }
    }

    /** Runs [test] with a running camera whose images have poses. */
    private fun withPoses(test: suspend ReceiveTurbine<Any>.(CameraRig.Running) -> Unit) {
        poses.isThere = true
        withCamera(test = test)
    }

    /** Runs [test] with a running camera and copies of what it delivers. */
    private fun withCamera(mode: Mode = JPEG, test: suspend ReceiveTurbine<Any>.(CameraRig.Running) -> Unit) =
        runBlocking {
            rig.add("1", listOf(mode))
            copies().test {
                test(rig.awaitRunning())
                cancel()
            }
        }

    /** Runs [test], which sees the end of the flow of a running camera, and asserts that the camera is closed. */
    private fun untilItEnds(mode: Mode = JPEG, test: suspend ReceiveTurbine<Sample>.(CameraRig.Running) -> Unit) =
        runBlocking {
            rig.add("1", listOf(mode))
            source.samples(StreamTable.color, values).test { test(rig.awaitRunning()) }
            assertTrue(CameraRig.opened.isClosed)
        }

    private fun copies(stream: StreamSpec = StreamTable.color, values: StreamValues = this.values): Flow<Any> =
        source.samples(stream, values).map { if (it is ImageSample) Copied(it, it.copy()) else it }

    private suspend fun ReceiveTurbine<Any>.awaitImage(): Copied = assertIs<Copied>(awaitItem())

    private suspend fun ReceiveTurbine<Sample>.awaitLossesAndError(
        image: (ImageSample) -> Unit = { error("an image") },
    ): Pair<Map<DropReason, Int>, Throwable> {
        val lost = mutableMapOf<DropReason, Int>()
        while (true) {
            val event = awaitEvent()
            if (event is Event.Error) return lost to event.throwable
            when (val sample = assertIs<Event.Item<Sample>>(event).value) {
                is ImageSample -> image(sample)
                is LostSamples -> lost.merge(sample.reason, sample.count, Int::plus)
                else -> error("a camera delivered $sample")
            }
        }
    }

    private fun CameraRig.Running.capture(image: FakeImage) = with(rig) {
        image(image)
        result(image.timestamp)
    }

    /** Captures an image that begins now, whose result has [tags]. */
    private fun CameraRig.Running.capture(tags: Map<String, Any>) = with(rig) {
        result(device.monotonicNanos, tags = tags)
        image(FakeImage.jpeg(device.monotonicNanos, byteArrayOf(1)))
    }

    private companion object {
        const val SECOND = 1_000_000_000L
        const val WORKERS = 2
        val VGA = Size(640, 480)
        val JPEG = Mode(ImageFormat.JPEG, VGA, minNanos = 33_333_333)
        val CENTRE = mapOf("com.amd.control.cvip_timestamps" to longArrayOf(0, 200, 0, 0))
        val YUV = Mode(ImageFormat.YUV_420_888, VGA, minNanos = 33_333_333)
    }
}
