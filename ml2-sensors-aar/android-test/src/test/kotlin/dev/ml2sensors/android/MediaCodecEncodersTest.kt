package dev.ml2sensors.android

import android.media.MediaCodecInfo.CodecCapabilities
import android.media.MediaCodecInfo.EncoderCapabilities
import android.media.MediaFormat
import dev.ml2sensors.TEST_LIMIT
import dev.ml2sensors.source.CaptureMetadata
import dev.ml2sensors.source.ImageSample
import dev.ml2sensors.source.SourceException
import dev.ml2sensors.source.VideoEncoder
import dev.ml2sensors.source.VideoOutput
import dev.ml2sensors.source.VideoPacket
import dev.ml2sensors.source.VideoSettings
import dev.ml2sensors.source.hasParameterSets
import dev.ml2sensors.source.isKeyFrame
import org.junit.After
import org.junit.Before
import org.junit.Test
import org.junit.runner.RunWith
import org.robolectric.RobolectricTestRunner
import org.robolectric.annotation.Config
import org.robolectric.shadow.api.Shadow
import java.io.IOException
import java.nio.ByteBuffer
import java.util.concurrent.LinkedBlockingQueue
import java.util.concurrent.TimeUnit
import kotlin.test.assertContentEquals
import kotlin.test.assertEquals
import kotlin.test.assertFailsWith
import kotlin.test.assertFalse
import kotlin.test.assertIs
import kotlin.test.assertNotNull
import kotlin.test.assertNull
import kotlin.test.assertTrue

/** On Android 10's own MediaCodec, with openh264 below it. */
@RunWith(RobolectricTestRunner::class)
@Config(sdk = [29], manifest = Config.NONE, shadows = [AvcCodec::class])
class MediaCodecEncodersTest {
    private class Packet(val micros: Long, val isKeyFrame: Boolean, val hasParameterSets: Boolean)

    private val packets = LinkedBlockingQueue<Packet>()
    private val failures = LinkedBlockingQueue<Exception>()
    private val output = object : VideoOutput {
        override fun packet(packet: VideoPacket) {
            packets += Packet(packet.presentationMicros, packet.bytes.isKeyFrame(), packet.bytes.hasParameterSets())
        }

        override fun failed(cause: Exception) {
            failures += cause
        }
    }

    private val uncaught = LinkedBlockingQueue<Throwable>()

    @Before
    fun watchThreads(): Unit = Thread.setDefaultUncaughtExceptionHandler { _, cause -> uncaught += cause }

    @After
    fun reset() {
        Thread.setDefaultUncaughtExceptionHandler(null)
        AvcCodec.reset()
    }

    @Test
    fun imagesComeBackAsH264WithTheirTimes() {
        AvcCodec.install(WIDTH, HEIGHT)
        val times = List(5) { 1_000_000L + 33_333 * it }
        MediaCodecEncoders().open(SETTINGS, output).use { encoder ->
            times.forEachIndexed { index, micros ->
                encoder.put(picture(index), micros, asKeyFrame = index in setOf(0, 3))
            }
            val found = times.map { packet() }
            assertEquals(times, found.map { it.micros })
            assertEquals(listOf(true, false, false, true, false), found.map { it.isKeyFrame })
            assertEquals(found.map { it.isKeyFrame }, found.map { it.hasParameterSets })
        }
        assertTrue(failures.isEmpty())
    }

    @Test
    fun theEncoderGetsThePixelsInWhateverLayoutItHas() {
        for (layout in AvcCodec.Layout.entries) {
            AvcCodec.reset()
            AvcCodec.layout = layout
            AvcCodec.install(WIDTH, HEIGHT)
            val color = picture(1)
            val grey = grey(color)
            MediaCodecEncoders().open(SETTINGS, output).use { encoder ->
                encoder.put(color, 1, asKeyFrame = true)
                encoder.put(grey, 2, asKeyFrame = false)
                repeat(2) { packet() }
            }
            val (first, second) = AvcCodec.inputs.toList()
            assertContentEquals(Y + U + V, first, "$layout")
            assertContentEquals(Y, second.copyOf(WIDTH * HEIGHT), "$layout")
            assertTrue(second.drop(WIDTH * HEIGHT).all { it == 128.toByte() }, "$layout: grey has no colour")
        }
    }

    @Test
    fun parameterSetsThatComeOnceAreBeforeEachKeyFrame() {
        AvcCodec.sendsParameterSetsOnce = true
        AvcCodec.install(WIDTH, HEIGHT)
        MediaCodecEncoders().open(SETTINGS, output).use { encoder ->
            encoder.put(picture(0), 1, asKeyFrame = true)
            for (index in 1..3) encoder.put(picture(index), 1L + index, asKeyFrame = index != 2)
            val found = List(3) { packet() }
            assertEquals(listOf(2L, 3L, 4L), found.map { it.micros })
            assertEquals(listOf(true, false, true), found.map { it.isKeyFrame })
            assertEquals(listOf(true, false, true), found.map { it.hasParameterSets })
        }
    }

    @Test
    fun theFormatIsThatOfALiveVideo() {
        AvcCodec.install(WIDTH, HEIGHT)
        MediaCodecEncoders().open(SETTINGS, output).close()
        val format = AvcCodec.format
        assertEquals(SETTINGS.bitsPerSecond, format.getInteger(MediaFormat.KEY_BIT_RATE))
        assertEquals(EncoderCapabilities.BITRATE_MODE_CBR, format.getInteger(MediaFormat.KEY_BITRATE_MODE))
        assertEquals(1, format.getInteger(MediaFormat.KEY_LATENCY))
        assertEquals(0, format.getInteger(MediaFormat.KEY_MAX_B_FRAMES))
        assertEquals(1, format.getInteger(MediaFormat.KEY_PREPEND_HEADER_TO_SYNC_FRAMES))
        assertEquals(MediaFormat.COLOR_RANGE_FULL, format.getInteger(MediaFormat.KEY_COLOR_RANGE))
    }

    @Test
    fun anEncoderWithoutConstantBitRateHasItsOwn() {
        AvcCodec.bitRateModes = "VBR"
        AvcCodec.install(WIDTH, HEIGHT)
        MediaCodecEncoders().open(SETTINGS, output).close()
        assertFalse(AvcCodec.format.containsKey(MediaFormat.KEY_BITRATE_MODE))
    }

    @Test
    fun whatNoEncoderTakesIsRefusedWithWhatThereIs() {
        val asked = "no encoder for h264 takes ${WIDTH}x$HEIGHT at 30 Hz and 2 Mbit/s; this headset has: "
        assertEquals("${asked}none", MediaCodecEncoders().refusal(SETTINGS))
        AvcCodec.reset()
        AvcCodec.install(WIDTH, HEIGHT, CodecCapabilities.COLOR_FormatSurface)
        assertEquals("$asked${AvcCodec.NAME}", MediaCodecEncoders().refusal(SETTINGS), "it takes no pixels")
        AvcCodec.reset()
        AvcCodec.install(WIDTH, HEIGHT)
        assertNull(MediaCodecEncoders().refusal(SETTINGS))
        val most = MediaCodecEncoders().refusal(SETTINGS.copy(width = 10_000, height = 10_000))
        assertTrue(assertNotNull(most).startsWith("no encoder for h264 takes 10000x10000"), most)
    }

    @Test
    fun anEncoderThatDoesNotOpenIsAFailureOfTheSource() {
        AvcCodec.install(WIDTH, HEIGHT)
        AvcCodec.failures["configure"] = IllegalStateException("all chips are in use")
        val failure = assertFailsWith<SourceException> { MediaCodecEncoders().open(SETTINGS, output) }
        assertEquals(
            "Android's encoder ${AvcCodec.NAME} does not take ${WIDTH}x$HEIGHT at 30 Hz and 2 Mbit/s: all chips are in use",
            failure.message,
        )
        assertFalse(hasThread())
    }

    @Test
    fun whateverAnEncoderThrowsWhenItOpensNothingOfItIsLeft() {
        AvcCodec.install(WIDTH, HEIGHT)
        for (call in listOf("createByCodecName", "setCallback", "configure", "start")) {
            for (refusal in FAILURES + IOException("no")) {
                AvcCodec.failures[call] = refusal
                repeat(5) {
                    val failure = assertFailsWith<SourceException> { MediaCodecEncoders().open(SETTINGS, output) }
                    assertTrue(failure.message.orEmpty().endsWith(": no"), "$call: $failure")
                }
                assertFalse(hasThread(), "$call: $refusal")
            }
            AvcCodec.failures.clear()
        }
    }

    @Test
    fun whateverAnEncoderThrowsWhileItRunsIsAFailureOfTheSourceAndNothingOfItIsLeft() {
        AvcCodec.install(WIDTH, HEIGHT)
        val ofInputs = listOf("getInputBuffer", "getInputImage", "setParameters", "queueInputBuffer")
        val ofOutputs = listOf("getOutputBuffer", "releaseOutputBuffer")
        for (call in ofInputs + ofOutputs + "release") {
            for (thrown in FAILURES) {
                val encoder = MediaCodecEncoders().open(SETTINGS, output)
                AvcCodec.failures[call] = thrown
                val encoding = runCatching { encoder.put(picture(0), 1, asKeyFrame = true) }
                val failure = if (call in ofOutputs) failure() else encoding.exceptionOrNull()
                encoder.close()
                AvcCodec.failures.clear()
                val expected = "Android's encoder ${AvcCodec.NAME} failed: no".takeIf { call != "release" }
                assertEquals(expected, failure?.message, "$call: $thrown")
                assertFalse(hasThread(), "$call: $thrown")
            }
        }
        assertTrue(uncaught.isEmpty(), "an exception that leaves a thread ends the app: $uncaught")
    }

    @Test
    fun anErrorOfTheChipIsAFailureOfTheSource() {
        AvcCodec.install(WIDTH, HEIGHT)
        val encoder = MediaCodecEncoders().open(SETTINGS, output)
        encoder.codec().fail()
        assertEquals("Android's encoder ${AvcCodec.NAME} failed: the chip is gone", failure().message)
        encoder.close()
        assertFalse(hasThread())
    }

    private fun failure() = assertIs<SourceException>(
        failures.poll(TEST_LIMIT.inWholeMilliseconds, TimeUnit.MILLISECONDS),
    )

    private fun packet() = assertNotNull(
        packets.poll(TEST_LIMIT.inWholeMilliseconds, TimeUnit.MILLISECONDS),
        "a packet; failures: $failures",
    )

    /** Waits for room, as the library's streams do not. */
    private fun VideoEncoder.put(image: ImageSample, micros: Long, asKeyFrame: Boolean) {
        while (!encode(image, micros, asKeyFrame)) Thread.onSpinWait()
    }

    private fun VideoEncoder.codec(): AvcCodec {
        val field = MediaCodecEncoder::class.java.getDeclaredField("codec").apply { isAccessible = true }
        return Shadow.extract(field[this])
    }

    private fun hasThread() = Thread.getAllStackTraces().keys.any { it.name == "ml2s-video" }

    internal companion object {
        val FAILURES = listOf(
            IllegalStateException("no"),
            AvcCodec.codecException("no"),
            IllegalArgumentException("no"),
            NullPointerException("no"),
            SecurityException("no"),
        )
        const val WIDTH = 96
        const val HEIGHT = 64
        val SETTINGS = VideoSettings(WIDTH, HEIGHT, rateHz = 30, bitsPerSecond = 2_000_000)
        val Y = ByteArray(WIDTH * HEIGHT) { (it % WIDTH + 2 * (it / WIDTH)).toByte() }
        val U = ByteArray(WIDTH * HEIGHT / 4) { (100 + it % (WIDTH / 2)).toByte() }
        val V = ByteArray(WIDTH * HEIGHT / 4) { (90 + it / (WIDTH / 2)).toByte() }

        fun direct(bytes: ByteArray): ByteBuffer = ByteBuffer.allocateDirect(bytes.size).put(bytes).flip()

        fun picture(number: Int) = sample(
            ImageSample.Plane(ImageSample.IMAGE, direct(Y)),
            ImageSample.Plane(ImageSample.CHROMA, direct(V.zip(U).flatMap { (v, u) -> listOf(v, u) }.toByteArray())),
            number = number,
        )

        fun grey(picture: ImageSample) = sample(ImageSample.Plane(ImageSample.IMAGE, picture.pixels), number = 9)

        fun sample(vararg planes: ImageSample.Plane, number: Int) = ImageSample(
            captureNanos = number.toLong(),
            frameNumber = number.toLong(),
            WIDTH,
            HEIGHT,
            strideBytes = WIDTH,
            pose = null,
            intrinsics = null,
            CaptureMetadata(),
            planes.toList(),
        ) {}
    }
}
