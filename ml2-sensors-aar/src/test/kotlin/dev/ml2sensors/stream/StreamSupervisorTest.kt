package dev.ml2sensors.stream

import dev.ml2sensors.message.Transform
import dev.ml2sensors.source.Answer
import dev.ml2sensors.source.DropReason
import dev.ml2sensors.source.LostSamples
import dev.ml2sensors.source.PoseSample
import dev.ml2sensors.source.RefusedException
import dev.ml2sensors.source.Sample
import dev.ml2sensors.source.SourceException
import dev.ml2sensors.source.VectorSample
import dev.ml2sensors.table.StreamTable
import kotlinx.coroutines.CancellationException
import kotlinx.coroutines.ExperimentalCoroutinesApi
import kotlinx.coroutines.awaitCancellation
import kotlinx.coroutines.cancelAndJoin
import kotlinx.coroutines.delay
import kotlinx.coroutines.flow.Flow
import kotlinx.coroutines.flow.FlowCollector
import kotlinx.coroutines.flow.flow
import kotlinx.coroutines.launch
import kotlinx.coroutines.test.TestScope
import kotlinx.coroutines.test.advanceTimeBy
import kotlinx.coroutines.test.currentTime
import kotlinx.coroutines.test.runCurrent
import kotlinx.coroutines.test.runTest
import org.junit.jupiter.api.Test
import java.io.IOException
import kotlin.test.assertEquals
import kotlin.test.assertFalse
import kotlin.test.assertTrue
import kotlin.time.AbstractLongTimeSource
import kotlin.time.Duration
import kotlin.time.Duration.Companion.milliseconds
import kotlin.time.Duration.Companion.minutes
import kotlin.time.Duration.Companion.seconds
import kotlin.time.DurationUnit

/** In virtual time. */
@OptIn(ExperimentalCoroutinesApi::class)
class StreamSupervisorTest {
    private val told = ArrayList<StreamState?>()
    private val begins = ArrayList<Duration>()
    private var collected = 0
    private var isHeld = false
    private var sleepReason: String? = null
    private var isFuture = false
    private var stoodStill = Duration.ZERO

    @Test
    fun aSourceThatFailsOnceComesBack() = runTest {
        supervise { run ->
            emit(SAMPLE)
            if (run == 1) throw IOException("unplugged")
            awaitCancellation()
        }
        advanceTimeBy(1.seconds)
        assertEquals<List<StreamState?>>(listOf(StreamState.Waiting("IOException: unplugged"), null), told)
        assertEquals(listOf(Duration.ZERO, 200.milliseconds), begins)
        assertEquals(2, collected)
    }

    @Test
    fun aReasonIsToldOnceHoweverOftenItIsMet() = runTest {
        supervise { run ->
            if (run <= 3) throw IOException("asleep")
            if (run == 4) throw IOException("in use")
            emit(SAMPLE)
            awaitCancellation()
        }
        advanceTimeBy(1.minutes)
        val reasons = listOf("IOException: asleep", "IOException: in use").map { StreamState.Waiting(it) }
        assertEquals<List<StreamState?>>(reasons + null, told)
    }

    @Test
    fun aStreamWhoseSamplesCannotBeEncodedDoesNotRunInBetween() = runTest {
        supervise(process = { throw SourceException("no encoder") }) { emit(SAMPLE) }
        advanceTimeBy(1.minutes)
        assertTrue(begins.size > 5)
        assertEquals<List<StreamState?>>(listOf(StreamState.Waiting("no encoder")), told)
    }

    @Test
    fun pausesGrowAndAreShortAgainAfterItDeliveredForAWhile() = runTest {
        supervise { run ->
            if (run < 8) throw IOException("asleep")
            emit(SAMPLE)
            if (run == 8) {
                delay(10.seconds)
                emit(SAMPLE)
            }
            throw IOException("evicted")
        }
        advanceTimeBy(45.seconds)
        val pauses = begins.zipWithNext { a, b -> b - a }
        val growing = listOf(200, 400, 800, 1600, 3200, 5000, 5000).map { it.milliseconds }
        assertEquals(growing + listOf(10.seconds, 400.milliseconds), pauses.take(9))
    }

    @Test
    fun aSourceThatFailsForEverIsTriedAtMostEveryFiveSeconds() = runTest {
        supervise { throw IOException("gone") }
        advanceTimeBy(10.minutes)
        assertEquals(1, told.size)
        assertEquals(5.seconds, begins.takeLast(2).let { (a, b) -> b - a })
    }

    @Test
    fun aSourceThatDeliversOneSampleEachTimeIsTriedNoMoreOften() = runTest {
        supervise {
            emit(SAMPLE)
            throw IOException("flapping")
        }
        advanceTimeBy(10.minutes)
        assertEquals(5.seconds, begins.takeLast(2).let { (a, b) -> b - a })
    }

    @Test
    fun aSourceThatEndsIsOpenedAgain() = runTest {
        supervise { run ->
            emit(SAMPLE)
            if (run > 1) awaitCancellation()
        }
        advanceTimeBy(1.seconds)
        assertEquals<List<StreamState?>>(listOf(StreamState.Waiting("the source has ended"), null), told)
    }

    @Test
    fun whatIsNoExceptionAndACancellationThatNobodyAskedForAreFailuresToo() = runTest {
        supervise { run ->
            if (run == 1) throw UnsatisfiedLinkError("no symbol")
            if (run == 2) throw CancellationException("closed")
            emit(SAMPLE)
            awaitCancellation()
        }
        advanceTimeBy(1.seconds)
        assertEquals("UnsatisfiedLinkError: no symbol", (told[0] as StreamState.Waiting).reason)
        assertEquals(null, told.last())
    }

    @Test
    fun aPermissionThatIsMissingIsNamed() = runTest {
        supervise { run ->
            if (run == 1) throw Denied("not allowed", "b.permission")
            throw RefusedException(StreamTable.worldLeft, Answer.Refused("not granted", "a.permission"))
        }
        advanceTimeBy(1.seconds)
        assertEquals(StreamState.Waiting("not allowed", "b.permission"), told[0])
        assertEquals(StreamState.Refused("not granted", "a.permission"), told[1])
    }

    @Test
    fun aSourceThatFallsSilentIsToldAndOpenedAgain() = runTest {
        supervise(PAUSE) { run ->
            emit(SAMPLE)
            if (run == 1) awaitCancellation()
            delay(PAUSE - 1.milliseconds)
            emitEvery(PAUSE - 1.milliseconds)
        }
        advanceTimeBy(1.minutes)
        assertEquals<List<StreamState?>>(listOf(StreamState.Waiting("no capture for 4 s"), null), told)
        assertEquals(listOf(Duration.ZERO, PAUSE), begins)
    }

    @Test
    fun aStandstillOfTheHeadsetIsNoSilenceOfASource() = runTest {
        supervise(PAUSE) { emitEvery(300.milliseconds) }
        repeat(10) {
            advanceTimeBy(20.seconds)
            stoodStill += 10.seconds
        }
        assertEquals(emptyList(), told)
        assertEquals(1, begins.size)
    }

    @Test
    fun aSourceThatIsSilentAfterAStandstillIsTold() = runTest {
        supervise(PAUSE) {
            emit(SAMPLE)
            awaitCancellation()
        }
        advanceTimeBy(2.seconds)
        stoodStill += 10.seconds
        advanceTimeBy(PAUSE * 2 - 2.seconds)
        assertEquals(emptyList(), told)
        runCurrent()
        assertEquals<StreamState?>(StreamState.Waiting("no capture for 4 s"), told.first())
    }

    @Test
    fun theFirstSampleMayTakeLonger() = runTest {
        supervise(PAUSE) {
            delay(PAUSE + 5.seconds)
            emitEvery(1.seconds)
        }
        advanceTimeBy(1.minutes)
        assertEquals(1, begins.size)
        assertEquals(emptyList(), told)
    }

    @Test
    fun aSourceThatNeverDeliversIsToldAndTriedAgain() = runTest {
        supervise(PAUSE) { awaitCancellation() }
        advanceTimeBy(1.minutes)
        assertEquals<List<StreamState?>>(listOf(StreamState.Waiting("no capture for 4 s")), told)
        assertTrue(begins.size in 4..6, "$begins")
    }

    @Test
    fun lossesAreNoSignOfLife() = runTest {
        supervise(PAUSE) { emitEvery(100.milliseconds) { LostSamples(1, 1, DropReason.UNUSABLE) } }
        advanceTimeBy(PAUSE + 7.seconds)
        assertEquals<List<StreamState?>>(listOf(StreamState.Waiting("no capture for 4 s")), told)
    }

    @Test
    fun aSilenceThatTheHeadsetExplainsIsNoFailure() = runTest {
        isHeld = true
        supervise(PAUSE) {
            emit(SAMPLE)
            awaitCancellation()
        }
        advanceTimeBy(1.minutes)
        assertEquals(emptyList(), told)
        isHeld = false
        advanceTimeBy(PAUSE + 1.milliseconds)
        assertEquals<StreamState?>(StreamState.Waiting("no capture for 4 s"), told.first())
    }

    @Test
    fun whileTheHeadsetSleepsASilentStreamWaitsAndStaysOpen() = runTest {
        sleepReason = "not worn"
        supervise(PAUSE) {
            emit(SAMPLE)
            delay(1.minutes)
            emitEvery(1.seconds)
        }
        advanceTimeBy(2.minutes)
        assertEquals<List<StreamState?>>(listOf(StreamState.Waiting("not worn"), null), told)
        assertEquals(1, begins.size)
    }

    @Test
    fun aStreamThatMayBeSilentIsNotOpenedAgain() = runTest {
        supervise { awaitCancellation() }
        advanceTimeBy(60.minutes)
        assertEquals(1, begins.size)
    }

    @Test
    fun posesThatAreNotTrackedAreToldAndTheSourceStaysOpen() = runTest {
        var pose: Transform? = Transform.IDENTITY
        supervise(PAUSE) { emitEvery(16.milliseconds) { PoseSample(1, pose) } }
        advanceTimeBy(10.seconds)
        pose = null
        advanceTimeBy(PAUSE - 1.seconds)
        assertEquals(emptyList(), told, "shorter losses of tracking are normal")
        advanceTimeBy(2.seconds)
        val lost = StreamState.Waiting("tracking is lost: the headset delivers no pose")
        assertEquals<List<StreamState?>>(listOf(lost), told)
        pose = Transform.IDENTITY
        advanceTimeBy(1.seconds)
        assertEquals<List<StreamState?>>(listOf(lost, null), told)
        assertEquals(1, begins.size)
    }

    @Test
    fun captureTimesInTheFutureAreToldAndTheSourceStaysOpen() = runTest {
        isFuture = true
        supervise(longestPause = 2.seconds) { emitEvery(10.milliseconds) }
        advanceTimeBy(1.seconds)
        assertEquals(emptyList(), told)
        advanceTimeBy(10.seconds)
        val reason = StreamState.Waiting("its capture times are more than a second ahead of the headset's clock")
        assertEquals<List<StreamState?>>(listOf(reason), told)
        isFuture = false
        advanceTimeBy(1.seconds)
        assertEquals<List<StreamState?>>(listOf(reason, null), told)
        assertEquals(1, begins.size)
    }

    @Test
    fun stoppedWhileItWaitsItIsNotOpenedAgain() = runTest {
        val job = supervise { throw IOException("gone") }
        runCurrent()
        job.cancelAndJoin()
        advanceTimeBy(1.minutes)
        assertEquals(1, begins.size)
        assertFalse(job.isActive)
    }

    private fun TestScope.supervise(
        longestPause: Duration? = null,
        process: (Sample) -> Unit = { collected++ },
        source: suspend FlowCollector<Sample>.(run: Int) -> Unit,
    ) = backgroundScope.launch {
        fun open(): Flow<Sample> = flow {
            begins += currentTime.milliseconds
            source(begins.size)
        }
        val time = object : AbstractLongTimeSource(DurationUnit.MILLISECONDS) {
            override fun read() = currentTime + stoodStill.inWholeMilliseconds
        }
        StreamSupervisor(longestPause, { isHeld }, { sleepReason }, time, { isFuture }) { told += it }
            .run(::open) { samples -> samples.collect { process(it) } }
    }

    private suspend fun FlowCollector<Sample>.emitEvery(period: Duration, sample: () -> Sample = { SAMPLE }) {
        while (true) {
            emit(sample())
            delay(period)
        }
    }

    private class Denied(message: String, override val permission: String) : SourceException(message)

    private companion object {
        val SAMPLE = VectorSample(1, 0.0, 0.0, 0.0)
        val PAUSE = 4.seconds
    }
}
