package dev.ml2sensors.capture

import dev.ml2sensors.message.Transform
import dev.ml2sensors.source.DropReason
import dev.ml2sensors.source.ImageSample
import dev.ml2sensors.source.LostSamples
import dev.ml2sensors.source.Sample
import dev.ml2sensors.source.SourceException
import dev.ml2sensors.source.VideoEncoder
import dev.ml2sensors.source.VideoEncoders
import dev.ml2sensors.source.VideoOutput
import dev.ml2sensors.source.VideoPacket
import dev.ml2sensors.source.VideoSettings
import dev.ml2sensors.source.isKeyFrame
import dev.ml2sensors.source.testImage
import dev.ml2sensors.table.StreamTable
import kotlinx.coroutines.flow.flow
import kotlinx.coroutines.flow.toList
import kotlinx.coroutines.flow.transform
import kotlinx.coroutines.runBlocking
import kotlinx.coroutines.yield
import org.junit.jupiter.api.AfterEach
import org.junit.jupiter.api.BeforeEach
import org.junit.jupiter.api.Test
import java.nio.ByteBuffer
import kotlin.test.assertContentEquals
import kotlin.test.assertEquals
import kotlin.test.assertFailsWith
import kotlin.test.assertFalse
import kotlin.test.assertSame
import kotlin.test.assertTrue

class VideoStreamTest {
    private val encoder = ScriptedEncoder()
    private val channel = ScriptedChannel()

    @BeforeEach
    fun begin(): Unit = Simulation.begin()

    @AfterEach
    fun nothingIsLeft() {
        assertEquals(0, Native.mappedBytes())
        Simulation.assertIsLeftAsFound()
    }

    @Test
    fun eachImageBecomesItsAccessUnit() {
        val images = images(3)
        val found = encoded(images).filterIsInstance<Encoded>()
        assertEquals(images.map { it.captureNanos }, found.map { it.captureNanos })
        assertContentEquals(KEY_FRAME, found[0].packet)
        assertContentEquals(OTHER_FRAME, found[1].packet)
        val first = found[0]
        assertSame(images[0].metadata, first.metadata)
        assertSame(images[0].pose, first.pose)
        assertEquals(images[0].frameNumber to 0, first.frameNumber to first.strideBytes)
        assertEquals(listOf(0L, 33_333L, 66_666L), encoder.times)
    }

    @Test
    fun aKeyFrameIsAskedForEachSecond() {
        encoded(images(65))
        assertEquals(listOf(0, 31, 62), encoder.keyFrames)
    }

    @Test
    fun whatTheLinkRefusesIsCountedAndHarmsNoOtherImage() {
        channel.refusals[1] = DropReason.QUEUE_FULL
        channel.refusals[2] = DropReason.LINK_DOWN
        assertEncoded(5, listOf(0, 3, 4), DropReason.QUEUE_FULL to 1, DropReason.LINK_DOWN to 1)
        assertEquals(listOf(0), encoder.keyFrames)
    }

    @Test
    fun aRateThatWasLoweredLeavesImagesOutUncounted() {
        channel.leavesOut += setOf(1, 3)
        assertEncoded(5, listOf(0, 2, 4))
    }

    @Test
    fun afterALostPacketNothingComesUntilTheKeyFrameThatIsAskedFor() {
        encoder.actions[3] = { channel.droppedPackets++ }
        encoder.delayOfRequests = 2
        assertEncoded(8, listOf(0, 1, 2, 6, 7), DropReason.AWAITING_KEY_FRAME to 3)
        assertEquals(listOf(0, 4), encoder.keyFrames)
    }

    @Test
    fun aBusyEncoderLosesImagesButNoRequest() {
        encoder.refuses += setOf(0, 2)
        assertEncoded(4, listOf(1, 3), DropReason.ENCODER_BUSY to 2)
        assertEquals(listOf(1), encoder.keyFrames)
    }

    @Test
    fun imagesThatTheEncoderLeavesOutAreCounted() {
        encoder.skips += setOf(2, 3)
        assertEncoded(5, listOf(0, 1, 4), DropReason.ENCODER_BUSY to 2)
    }

    @Test
    fun imagesThatWaitToBeSentAreCountedForTheLink() {
        val held = mutableListOf<ImageSample>()
        encoded(images(4)) {
            it.retain()
            held += it
        }
        assertEquals(3, channel.most)
        held.forEach(ImageSample::release)
    }

    @Test
    fun withoutAFreeSlotThePacketIsLostAndAKeyFrameFollows() {
        val held = ArrayDeque<ImageSample>()
        encoder.actions[SlotPool.SLOTS + 1] = { held.removeFirst().release() }
        var seen = 0
        val found = encoded(images(SlotPool.SLOTS + 3)) {
            if (seen++ >= SlotPool.SLOTS) return@encoded
            it.retain()
            held += it
        }
        held.forEach(ImageSample::release)
        assertEquals(mapOf(DropReason.NO_BUFFER to 1), found.lost())
        assertEquals(listOf(0, SlotPool.SLOTS + 1), encoder.keyFrames)
    }

    @Test
    fun aCaptureThatIsNotLaterIsNotEncoded() {
        val found = encoded(listOf(image(5_000), image(5_000), image(4_000), image(6_000)))
        assertEquals(2, found.filterIsInstance<Encoded>().size)
        assertEquals(mapOf(DropReason.UNUSABLE to 2), found.lost())
    }

    @Test
    fun lossesOfTheSourceArePassedOn() {
        val found = encoded(listOf(image(0), LostSamples(1, 3, DropReason.SOURCE_LATE), image(PERIOD_NANOS)))
        assertEquals(mapOf(DropReason.SOURCE_LATE to 3), found.lost())
    }

    @Test
    fun aPacketLargerThanTheRawImageIsLost() {
        encoder.packetOf[1] = OTHER_FRAME + ByteArray(WIDTH * HEIGHT)
        assertEncoded(3, listOf(0, 2), DropReason.UNUSABLE to 1)
        assertEquals(listOf(0, 2), encoder.keyFrames)
    }

    @Test
    fun aFailureOfTheEncoderEndsTheStreamWithItsCause() {
        encoder.actions[2] = { encoder.output.failed(SourceException("the chip is gone")) }
        val failure = assertFailsWith<SourceException> { encoded(images(4)) }
        assertEquals("the chip is gone", failure.message)
    }

    @Test
    fun aFailureOfTheSourceEndsTheStreamAndTheEncoder() {
        val samples = flow<Sample> {
            emit(image(0))
            throw SourceException("unplugged")
        }
        val failure = assertFailsWith<SourceException> { runBlocking { stream().encoded(samples).toList() } }
        assertEquals("unplugged", failure.message)
        assertTrue(encoder.isClosed)
    }

    @Test
    fun anImageThatNobodyGaveIsAFailure() {
        encoder.actions[1] = { encoder.output.packet(VideoPacket(17, ByteBuffer.wrap(OTHER_FRAME))) }
        val failure = assertFailsWith<SourceException> { encoded(images(3)) }
        assertEquals("the encoder of world_left returned an image that it was not given", failure.message)
    }

    @Test
    fun keyFramesAreToldByTheirUnits() {
        val idr = byteArrayOf(0, 0, 1, 0x65, 9)
        val delimited = byteArrayOf(0, 0, 0, 1, 9, 0x10, 0, 0, 1, 6, 0, 0, 1)
        for (key in listOf(KEY_FRAME, idr, delimited + idr.drop(3))) assertTrue(ByteBuffer.wrap(key).isKeyFrame())
        val other =
            listOf(OTHER_FRAME, OTHER_FRAME + idr, delimited + OTHER_FRAME.drop(4), byteArrayOf(), byteArrayOf(0, 0, 1))
        for (frame in other) assertFalse(ByteBuffer.wrap(frame).isKeyFrame())
        assertTrue(ByteBuffer.wrap(OTHER_FRAME + idr).position(OTHER_FRAME.size).isKeyFrame(), "from the position on")
    }

    private fun stream() = VideoStream(StreamTable.worldLeft, encoder, SETTINGS, channel)

    /** Returns what comes of [samples], of images a copy; [use] sees them before their release. */
    private fun encoded(samples: List<Sample>, use: (ImageSample) -> Unit = {}): List<Any> = runBlocking {
        val given = flow {
            for (sample in samples) {
                emit(sample)
                yield() // the collector takes what came of it
            }
        }
        val found = stream().encoded(given).transform<Sample, Any> {
            if (it is ImageSample) {
                use(it)
                emit(Encoded(it))
            } else {
                emit(it)
            }
        }.toList()
        assertTrue(encoder.isClosed)
        found
    }

    /** Asserts what becomes of [count] images: the numbers of those that are encoded, and how many are [lost]. */
    private fun assertEncoded(count: Int, numbers: List<Int>, vararg lost: Pair<DropReason, Int>) {
        val found = encoded(images(count))
        assertEquals(numbers, found.filterIsInstance<Encoded>().map { (it.captureNanos / PERIOD_NANOS).toInt() })
        assertEquals(mapOf(*lost), found.lost())
    }

    private fun List<Any>.lost() =
        filterIsInstance<LostSamples>().groupBy { it.reason }.mapValues { (_, of) -> of.sumOf { it.count } }

    /** A copy of an encoded image, which is released itself. */
    private class Encoded(sample: ImageSample) {
        val captureNanos = sample.captureNanos
        val frameNumber = sample.frameNumber
        val strideBytes = sample.strideBytes
        val metadata = sample.metadata
        val pose = sample.pose
        val packet = sample.copy()
    }

    private class ScriptedChannel : VideoChannel {
        override var droppedPackets = 0L
        val refusals = mutableMapOf<Int, DropReason>()
        val leavesOut = mutableSetOf<Int>()
        var most = 0
            private set
        private var number = -1

        override fun admits(captureNanos: Long): Boolean = ++number !in leavesOut

        override fun refusal(images: Int): DropReason? {
            most = maxOf(most, images)
            return refusals[number]
        }
    }

    /** Encodes at once. What it does with an image is said by the image's number, from 0. */
    private class ScriptedEncoder :
        VideoEncoders(),
        VideoEncoder {
        val times = mutableListOf<Long>()
        val keyFrames = mutableListOf<Int>()
        val refuses = mutableSetOf<Int>()
        val skips = mutableSetOf<Int>()
        val packetOf = mutableMapOf<Int, ByteArray>()
        val actions = mutableMapOf<Int, () -> Unit>()

        /** So many images after the request comes the key frame; the first one comes at once. */
        var delayOfRequests = 0
        lateinit var output: VideoOutput
            private set
        var isClosed = false
            private set
        private var number = -1

        override fun refusal(settings: VideoSettings): String? = null

        override fun open(settings: VideoSettings, output: VideoOutput): VideoEncoder {
            this.output = output
            return this
        }

        override fun encode(image: ImageSample, presentationMicros: Long, asKeyFrame: Boolean): Boolean {
            number++
            if (number in refuses) return false
            times += presentationMicros
            if (asKeyFrame) keyFrames += number
            actions[number]?.invoke()
            if (number in skips) return true
            val isKeyFrame = (asKeyFrame && keyFrames.size == 1) || number - delayOfRequests == keyFrames.last()
            val packet = packetOf[number] ?: if (isKeyFrame) KEY_FRAME else OTHER_FRAME
            output.packet(VideoPacket(presentationMicros, ByteBuffer.wrap(packet)))
            return true
        }

        override fun close() {
            isClosed = true
        }
    }

    private companion object {
        const val WIDTH = 64
        const val HEIGHT = 32
        const val PERIOD_NANOS = 33_333_333L
        val SETTINGS = VideoSettings(WIDTH, HEIGHT, rateHz = 30, bitsPerSecond = 1_000_000)
        val KEY_FRAME = byteArrayOf(0, 0, 0, 1, 0x67, 1, 2, 0, 0, 1, 0x65, 3)
        val OTHER_FRAME = byteArrayOf(0, 0, 0, 1, 0x41, 4)

        fun image(captureNanos: Long) = testImage(
            WIDTH,
            HEIGHT,
            listOf(ImageSample.Plane(ImageSample.IMAGE, ByteBuffer.allocateDirect(WIDTH * HEIGHT))),
            captureNanos,
            frameNumber = captureNanos / PERIOD_NANOS + 100,
            pose = Transform.IDENTITY,
        )

        fun images(count: Int) = List(count) { image(it * PERIOD_NANOS) }
    }
}
