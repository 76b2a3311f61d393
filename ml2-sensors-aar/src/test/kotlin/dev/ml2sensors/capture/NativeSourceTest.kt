package dev.ml2sensors.capture

import dev.ml2sensors.source.Answer
import dev.ml2sensors.source.DropReason
import dev.ml2sensors.source.ImageSample
import dev.ml2sensors.source.LostSamples
import dev.ml2sensors.source.Sample
import dev.ml2sensors.table.StreamTable
import kotlinx.coroutines.CompletableDeferred
import kotlinx.coroutines.Dispatchers
import kotlinx.coroutines.async
import kotlinx.coroutines.cancelAndJoin
import kotlinx.coroutines.channels.Channel
import kotlinx.coroutines.flow.Flow
import kotlinx.coroutines.flow.collect
import kotlinx.coroutines.flow.first
import kotlinx.coroutines.flow.onEach
import kotlinx.coroutines.flow.take
import kotlinx.coroutines.flow.takeWhile
import kotlinx.coroutines.flow.toList
import kotlinx.coroutines.launch
import kotlinx.coroutines.runBlocking
import kotlinx.coroutines.yield
import org.junit.jupiter.api.AfterEach
import org.junit.jupiter.api.Test
import kotlin.test.assertEquals
import kotlin.test.assertFailsWith
import kotlin.test.assertIs
import kotlin.test.assertNotNull
import kotlin.test.assertTrue

/** Collectors that come, go, lag and keep; a device that fails. */
class NativeSourceTest {
    private val fixture = CaptureFixture()

    @AfterEach
    fun close(): Unit = fixture.close()

    @Test
    fun theSensorIsOpenWhileItIsCollected() = runBlocking<Unit> {
        assertEquals(0, Simulation.openHandles())
        fixture.image(EYE) { assertTrue(Simulation.openHandles() > 0) }
        assertEquals(0, Simulation.openHandles())
        fixture.image(EYE) { assertTrue(Simulation.openHandles() > 0) }
        assertEquals(0, Simulation.openHandles())
    }

    @Test
    fun aCollectorThatIsCancelledInTheMiddleOfAnImageGivesItBack() = runBlocking<Unit> {
        val holds = CompletableDeferred<ImageSample>()
        val collector = launch {
            fixture.samples(EYE).collect {
                if (it is ImageSample) holds.complete(it)
                CompletableDeferred<Unit>().await()
            }
        }
        val image = holds.await()
        collector.cancelAndJoin()
        assertFailsWith<IllegalStateException> { image.pixels }
        assertEquals(0, Simulation.openHandles())
    }

    @Test
    fun aSlowCollectorLosesTheOldestAndHoldsUpNobody() = runBlocking<Unit> {
        val others = Channel<Long>(Channel.UNLIMITED)
        val other = launch(Dispatchers.Default) { fixture.images(OTHER_EYE) { it.frameNumber }.collect(others::send) }
        val received = fixture.samples(EYE).onEach { if (it is ImageSample) others.awaitNew(8) }
            .takeUntil { images -> images == 3 }
        other.cancelAndJoin()
        assertEquals(setOf(DropReason.SOURCE_LATE), received.filterIsInstance<LostSamples>().map { it.reason }.toSet())
        assertBooksBalance(received)
    }

    @Test
    fun aCollectorThatKeepsAllMemoryLosesFramesUntilItGivesThemBack() = runBlocking<Unit> {
        val kept = ArrayDeque<ImageSample>()
        val received = mutableListOf<Sample>()
        var lost = 0
        val other = async(Dispatchers.Default) { fixture.images(OTHER_EYE) { it.frameNumber }.take(30).toList() }
        fun cameAgain() = lost >= 3 && received.last() is ImageSample
        fixture.samples(EYE).takeWhile { received.size < 600 && !cameAgain() }.collect { sample ->
            received += sample
            if (sample is LostSamples && sample.reason == DropReason.NO_BUFFER) lost++
            if (sample is ImageSample && lost == 0) kept += sample.also(ImageSample::retain)
            if (lost == 3) kept.removeAll { it.release().let { true } }
        }
        assertTrue(lost >= 3, "lost $lost")
        assertTrue(cameAgain(), "frames come again")
        assertBooksBalance(received)
        assertEquals(30, other.await().size)
    }

    @Test
    fun keptImagesAreReadableAfterTheSensorIsClosed() = runBlocking<Unit> {
        val kept = fixture.samples(EYE).first { it is ImageSample && it.retain().let { true } } as ImageSample
        assertEquals(0, Simulation.openHandles())
        val pixels = kept.copy()
        fixture.images(EYE) { }.take(20).collect()
        assertTrue(pixels.contentEquals(kept.copy()))
        kept.release()
    }

    @Test
    fun twoCollectorsOfOneStreamShareItsImages() = runBlocking<Unit> {
        assertNotNull(inCommon(fixture.images(EYE) { it.captureNanos }, fixture.images(EYE) { it.captureNanos }))
    }

    @Test
    fun everythingRunsAtOnceAndTheBooksBalance() = runBlocking<Unit> {
        val cameras = PixelSensor.entries - PixelSensor.COLOR
        val streams = cameras.flatMap { it.streams } - StreamTable.infra
        val head = launch(Dispatchers.Default) { fixture.samples(StreamTable.headPose).collect { } }
        val received = streams.map { stream ->
            async(Dispatchers.Default) { fixture.samples(stream).takeUntil { images -> images == 30 } }
        }
        received.forEach { assertBooksBalance(it.await()) }
        head.cancelAndJoin()
    }

    @Test
    fun aStalledCameraCanBeLeft() = runBlocking<Unit> {
        Simulation.configure("fault.eye.stalled", 1)
        val collector = launch(Dispatchers.Default) { fixture.samples(EYE).collect { } }
        while (Simulation.openHandles() == 0) yield()
        collector.cancelAndJoin()
        assertEquals(0, Simulation.openHandles())
    }

    @Test
    fun aStreamThatJoinsLeavesTheOthersRunning() = runBlocking<Unit> {
        val numbers = Channel<Long>(Channel.UNLIMITED)
        val running = launch(Dispatchers.Default) { fixture.images(EYE) { it.captureNanos }.collect(numbers::send) }
        numbers.receive()
        assertEquals(5, fixture.images(OTHER_EYE) { it.frameNumber }.take(5).toList().size)
        repeat(5) { numbers.receive() }
        running.cancelAndJoin()
    }

    @Test
    fun depthAndInfraredExcludeEachOther() = runBlocking<Unit> {
        fixture.image(StreamTable.depth) {
            runBlocking {
                val refused = assertFailsWith<CaptureException.InUse> { fixture.image(StreamTable.infra) { } }
                assertTrue("depth runs, and the camera delivers one of both at a time" in refused.message!!)
            }
        }
        fixture.image(StreamTable.infra) { }
    }

    @Test
    fun oneStreamHasOneSetOfValues() = runBlocking<Unit> {
        val low = CaptureFixture.values(StreamTable.worldLeft).copy(stream = 1)
        fixture.image(StreamTable.worldLeft) {
            runBlocking { assertFailsWith<CaptureException.InUse> { fixture.image(StreamTable.worldLeft, low) { } } }
        }
    }

    @Test
    fun aMissingPermissionEndsTheStreamsThatNeedIt() = runBlocking<Unit> {
        Simulation.configure("fault.eye.permission", 1)
        val denied = assertFailsWith<CaptureException.PermissionDenied> { fixture.image(EYE) { } }
        assertTrue("MLEyeCameraConnect" in denied.message!!, denied.message)
        fixture.image(StreamTable.worldLeft) { }
        Simulation.configure("fault.eye.permission", 0)
        fixture.image(EYE) { }
    }

    @Test
    fun aDeviceThatFailsWhileItRunsEndsAllStreamsOfTheSensor() = runBlocking<Unit> {
        val running = listOf(EYE, OTHER_EYE).map { stream ->
            val isRunning = CompletableDeferred<Unit>()
            isRunning to async(Dispatchers.Default) {
                assertFailsWith<CaptureException.VendorFailure> {
                    fixture.samples(stream).collect { isRunning.complete(Unit) }
                }
            }
        }
        running.forEach { (isRunning, _) -> isRunning.await() }
        Simulation.configure("fault.eye.get", 1)
        for ((_, failure) in running) {
            val message = failure.await().message!!
            assertTrue("MLEyeCameraGetLatestCameraData" in message, message)
        }
        assertEquals(0, Simulation.openHandles())
        Simulation.configure("fault.eye.get", 0)
        fixture.image(EYE) { }
    }

    @Test
    fun framesThatTheDeviceDropsAreCounted() = runBlocking<Unit> {
        Simulation.configure("fault.eye.drop_every", 4)
        val behind = mutableListOf<Long>()
        val received = fixture.samples(EYE)
            .onEach { if (it is ImageSample) behind += (Native.now() - it.captureNanos) / PERIOD_NANOS }
            .takeUntil { images -> images == 12 }
        val numbers = received.filterIsInstance<ImageSample>().map { it.frameNumber }
        assertTrue(numbers.map { it % 4 }.toSet().size <= 3, "every fourth number is missing: $numbers")
        val missing = numbers.last() - numbers.first() + 1 - numbers.size
        assertTrue(missing >= 3, "$numbers")
        // A loss is reported as soon as it is known: with an image that comes late, also one of frames after it
        val lost = received.dropWhile { it !is ImageSample }.filterIsInstance<LostSamples>().sumOf { it.count }
        val expected = missing - behind.first()..missing + behind[numbers.size - 1]
        assertTrue(lost in expected, "lost $lost, expected $expected, received $numbers")
        assertBooksBalance(received)
    }

    @Test
    fun aPauseGivesTheDeviceBackAndTheFlowsGoOn() = runBlocking<Unit> {
        val images = Channel<Long>(Channel.UNLIMITED)
        val running = launch(Dispatchers.Default) { fixture.images(EYE) { it.captureNanos }.collect(images::send) }
        images.receive()
        fixture.eyes.pause()
        while (Simulation.openHandles() > 0) yield()
        val pausedNanos = Native.now()
        fixture.eyes.resume()
        while (images.receive() < pausedNanos) continue
        running.cancelAndJoin()
    }

    @Test
    fun aPermissionThatIsTakenDuringAPauseEndsTheFlows() = runBlocking<Unit> {
        val isRunning = CompletableDeferred<Unit>()
        val failure = async(Dispatchers.Default) {
            assertFailsWith<CaptureException.PermissionDenied> {
                fixture.samples(EYE).collect { isRunning.complete(Unit) }
            }
        }
        isRunning.await()
        fixture.eyes.pause()
        while (Simulation.openHandles() > 0) yield()
        Simulation.configure("fault.eye.permission", 1)
        fixture.eyes.resume()
        failure.await()
        assertEquals(0, Simulation.openHandles())
    }

    @Test
    fun closingEndsTheFlows() = runBlocking<Unit> {
        val isRunning = CompletableDeferred<Unit>()
        val running = launch(Dispatchers.Default) { fixture.samples(EYE).collect { isRunning.complete(Unit) } }
        isRunning.await()
        fixture.eyes.close()
        running.join()
        assertEquals(0, Simulation.openHandles())
        assertFailsWith<IllegalStateException> { fixture.image(EYE) { } }.let { assertTrue("closed" in it.message!!) }
    }

    @Test
    fun whatTheTableDoesNotKnowIsRefused() {
        val depth = CaptureFixture.SHORT_RANGE
        assertEquals(Answer.Applied(depth), fixture.depth.negotiate(StreamTable.depth, depth))
        assertIs<Answer.Refused>(fixture.depth.negotiate(StreamTable.depth, depth.copy(rateHz = 24)))
        assertEquals(0, Simulation.openHandles())
    }

    /** Waits for [count] elements that were not there yet. */
    private suspend fun Channel<Long>.awaitNew(count: Int) {
        while (tryReceive().isSuccess) Unit
        repeat(count) { receive() }
    }

    /** Until [isEnough] images have come. */
    private suspend fun Flow<Sample>.takeUntil(isEnough: (images: Int) -> Boolean): List<Sample> {
        var images = 0
        val received = mutableListOf<Sample>()
        takeWhile { !isEnough(images) }.collect {
            received += it
            if (it is ImageSample) images++
        }
        return received
    }

    /**
     * No image follows a gap in the device's numbers that was not reported before it. (More may have been: a loss is
     * reported as soon as it is known, and it may be one of frames that would have come later.)
     */
    private fun assertBooksBalance(received: List<Sample>) {
        val first = received.first { it is ImageSample } as ImageSample
        var accounted = -1L
        for (sample in received) {
            accounted += if (sample is LostSamples) sample.count else 1
            if (sample is ImageSample) assertTrue(sample.frameNumber - first.frameNumber <= accounted, "$received")
        }
    }

    private companion object {
        const val PERIOD_NANOS = 1_000_000_000L / 30
        val EYE = StreamTable.eyeNasalLeft
        val OTHER_EYE = StreamTable.eyeTempleRight
    }
}
