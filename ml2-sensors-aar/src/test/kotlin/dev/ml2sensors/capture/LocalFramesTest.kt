package dev.ml2sensors.capture

import dev.ml2sensors.message.MlPose
import dev.ml2sensors.message.Quaternion
import dev.ml2sensors.message.Transform
import dev.ml2sensors.message.Vector3
import dev.ml2sensors.message.distanceTo
import dev.ml2sensors.source.Distortion
import dev.ml2sensors.source.ImageSample
import dev.ml2sensors.source.Intrinsics
import dev.ml2sensors.source.PoseSample
import dev.ml2sensors.source.VectorSample
import dev.ml2sensors.source.testImage
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable
import kotlinx.coroutines.Dispatchers
import kotlinx.coroutines.cancelAndJoin
import kotlinx.coroutines.flow.first
import kotlinx.coroutines.launch
import kotlinx.coroutines.runBlocking
import org.junit.jupiter.api.AfterEach
import org.junit.jupiter.api.Test
import java.nio.ByteBuffer
import java.nio.ByteOrder
import kotlin.test.assertContentEquals
import kotlin.test.assertEquals
import kotlin.test.assertNotNull
import kotlin.test.assertNull
import kotlin.test.assertTrue

/** Tests what readers beside Kotlin find in the slots. */
class LocalFramesTest {
    private val fixture = CaptureFixture()
    private val color = SlotPool(StreamTable.color)

    @AfterEach
    fun close() {
        color.close()
        StreamTable.all.forEach { LocalFrames.view(it, false) }
        fixture.close()
    }

    @Test
    fun aViewedStreamIsReadInTheVerySlotThatKotlinHas() = runBlocking<Unit> {
        LocalFrames.view(StreamTable.worldLeft, true)
        fixture.images(StreamTable.worldLeft) { it.captureNanos to it.copy() }.first { (captureNanos, pixels) ->
            val frame = LatestFrame.acquire(StreamTable.worldLeft)
            // A newer one may be there already
            val isSame = frame?.captureNanos == captureNanos
            if (isSame) assertContentEquals(pixels, assertNotNull(frame).pixels)
            frame?.release()
            isSame
        }
    }

    @Test
    fun nothingIsPublishedUnlessItIsViewed() = runBlocking<Unit> {
        LocalFrames.view(StreamTable.worldRight, true)
        fixture.image(StreamTable.worldLeft) {}
        assertNull(LatestFrame.acquire(StreamTable.worldLeft))
    }

    @Test
    fun nothingIsKeptForAViewerThatHasGone() = runBlocking<Unit> {
        LocalFrames.view(StreamTable.worldLeft, true)
        fixture.images(StreamTable.worldLeft) {}.first { LatestFrame.acquire(StreamTable.worldLeft)?.release() != null }
        LocalFrames.view(StreamTable.worldLeft, false)
        assertNull(LatestFrame.acquire(StreamTable.worldLeft))
    }

    @Test
    fun aReaderThatKeepsItsFramesLosesNewOnesAndTheCameraGoesOn() = runBlocking<Unit> {
        LocalFrames.view(StreamTable.worldLeft, true)
        val kept = ArrayList<LatestFrame>()
        fixture.images(StreamTable.worldLeft) {}.first {
            LatestFrame.acquire(StreamTable.worldLeft, kept.lastOrNull()?.captureNanos ?: 0)?.let(kept::add)
            kept.size == 5
        }
        fixture.image(StreamTable.worldLeft) { assertTrue(it.captureNanos >= kept.last().captureNanos) }
        assertEquals(5, kept.map { it.slot }.distinct().size)
        kept.forEach { it.release() }
    }

    @Test
    fun aJpegIsReadInItsSlot() {
        LocalFrames.view(StreamTable.color, true)
        val jpeg = ByteArray(1000) { it.toByte() }
        publish(jpeg)
        val frame = assertNotNull(LatestFrame.acquire(StreamTable.color))
        assertContentEquals(jpeg, frame.pixels)
        assertEquals(listOf(77L, 640L, 480L), listOf(frame.captureNanos, frame.width.toLong(), frame.height.toLong()))
        frame.release()
    }

    @Test
    fun jpegsComeWithPoseAndLens() {
        LocalFrames.view(StreamTable.color, true)
        val pose = Transform(Vector3(1.0, 2.0, 3.0), Quaternion(0.5, 0.5, -0.5, 0.5))
        for (lens in listOf(
            Distortion.PlumbBob(0.1, 0.2, 0.3, 0.4, 0.5),
            Distortion.FisheyeTangential(0.1, 0.2, 0.3, 0.4, 0.5, 0.6),
        )) {
            val intrinsics = Intrinsics(640, 480, 500.0, 501.0, 320.0, 240.0, lens)
            publish(ByteArray(10), pose, intrinsics)
            val frame = assertNotNull(LatestFrame.acquire(StreamTable.color))
            assertEquals(pose, frame.frame.pose?.toOptical())
            assertEquals(intrinsics, frame.frame.intrinsics)
            frame.release()
        }
        publish(ByteArray(10))
        val without = assertNotNull(LatestFrame.acquire(StreamTable.color))
        assertNull(without.frame.pose)
        assertNull(without.frame.intrinsics)
        without.release()
    }

    @Test
    fun framesHaveTheHeadsPoseAtTheirCapture() {
        LocalFrames.view(StreamTable.color, true)
        assertNull(publishedHeadPose())
        LocalFrames.addHead(PoseSample(67, Transform(Vector3(1.0, 0.0, 4.0), Quaternion.IDENTITY)))
        LocalFrames.addHead(PoseSample(87, Transform(Vector3(3.0, 2.0, 4.0), Quaternion.IDENTITY)))
        assertEquals(Transform(Vector3(2.0, 1.0, 4.0), Quaternion.IDENTITY), publishedHeadPose()?.toBody())
        LocalFrames.clearHead()
        assertNull(publishedHeadPose())
    }

    @Test
    fun aCamerasFramesHaveTheHeadsPoseWhileTheHeadIsTracked() = runBlocking<Unit> {
        LocalFrames.view(StreamTable.worldLeft, true)
        val head = launch(Dispatchers.Default) { fixture.samples(StreamTable.headPose).collect {} }
        fixture.images(StreamTable.worldLeft) {}.first {
            LatestFrame.acquire(StreamTable.worldLeft)?.run {
                val pose = frame.headPose
                val truth = Simulation.truth(Simulation.HEAD, captureNanos)
                release()
                if (pose != null) assertEquals(0.0, pose.toBody().distanceTo(truth.toBody()), 0.01)
                pose != null
            } == true
        }
        head.cancelAndJoin()
    }

    @Test
    fun readingsAreGatheredUpToTheLatest() {
        LocalFrames.view(StreamTable.gyroLeft, true)
        for (nanos in 1L..100) LocalFrames.copy(StreamTable.gyroLeft, VectorSample(nanos, nanos * 0.5, -1.0, 2.0))
        val frame = assertNotNull(LatestFrame.acquire(StreamTable.gyroLeft))
        assertEquals(100, frame.captureNanos)
        val found = ByteBuffer.wrap(frame.pixels).order(ByteOrder.LITTLE_ENDIAN)
        for (nanos in 37L..100) {
            assertEquals(nanos, found.getLong())
            assertEquals(listOf(nanos * 0.5, -1.0, 2.0), List(3) { found.getDouble() })
        }
        assertEquals(0, found.remaining())
        frame.release()
    }

    @Test
    fun jpegsAreNotPublishedUnlessTheyAreViewed() {
        publish(ByteArray(1000))
        assertNull(LatestFrame.acquire(StreamTable.color))
    }

    @Test
    fun withoutAFreeSlotReadingsAreLeftOut() {
        LocalFrames.view(StreamTable.gyroLeft, true)
        val pool = SlotPool(StreamTable.gyroLeft)
        val kept = List(SlotPool.SLOTS) { assertNotNull(pool.take(64)) }
        LocalFrames.copy(StreamTable.gyroLeft, VectorSample(1, 0.5, -1.0, 2.0))
        assertNull(LatestFrame.acquire(StreamTable.gyroLeft))
        kept.forEach { it.release() }
        pool.close()
    }

    @Test
    fun aReaderKeepsItsFrameThoughTheStreamHasEnded() = runBlocking<Unit> {
        LocalFrames.view(StreamTable.worldLeft, true)
        lateinit var kept: LatestFrame
        lateinit var pixels: ByteArray
        fixture.images(StreamTable.worldLeft) {}.first {
            LatestFrame.acquire(StreamTable.worldLeft)?.also {
                kept = it
                pixels = it.pixels
            } != null
        }
        assertNull(LatestFrame.acquire(StreamTable.worldLeft), "an ended stream has no latest frame")
        assertContentEquals(pixels, kept.pixels)
        assertEquals(1016L * 1016, Native.mappedBytes())
        kept.release()
        assertEquals(0, Native.mappedBytes())
    }

    /** The head's pose in the frame of an image that is published now. */
    private fun publishedHeadPose(): MlPose? {
        publish(ByteArray(10))
        val latest = assertNotNull(LatestFrame.acquire(StreamTable.color))
        return latest.frame.headPose.also { latest.release() }
    }

    /** Publishes an image of the colour camera, as an encoder does. */
    private fun publish(jpeg: ByteArray, pose: Transform? = null, intrinsics: Intrinsics? = null) {
        val slot = assertNotNull(color.take(640 * 480))
        slot.bytes.put(jpeg).flip()
        val planes = listOf(ImageSample.Plane(ImageSample.IMAGE, slot.bytes))
        val sample = testImage(
            640,
            480,
            planes,
            captureNanos = 77,
            strideBytes = 0,
            pose = pose,
            intrinsics = intrinsics,
            giveBack = slot::release,
        )
        LocalFrames.publish(slot, sample)
        sample.release()
    }
}

/** The lease of an ml2s_frame, as C# takes it; [release] ends it. */
private class LatestFrame(private val stream: StreamSpec, val frame: NativeFrame) {
    val slot get() = frame.slot
    val captureNanos get() = frame.captureNanos
    val width get() = frame.width
    val height get() = frame.height

    val pixels: ByteArray
        get() {
            val bytes = SlotPool.bytes(stream, slot, checkNotNull(frame.rangeOf(NativeFrame.IMAGE)))
            return ByteArray(bytes.remaining()).also(bytes::get)
        }

    fun release() = Native.release(stream.number, slot)

    companion object {
        /** Null when there is none after [afterNanos]. */
        fun acquire(stream: StreamSpec, afterNanos: Long = 0): LatestFrame? {
            val frames = FrameBlock(1)
            return if (Simulation.acquireLatest(stream.number, afterNanos, frames.memory)) {
                LatestFrame(stream, frames[0])
            } else {
                null
            }
        }
    }
}
