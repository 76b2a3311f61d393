package dev.ml2sensors.source

import dev.ml2sensors.test
import kotlinx.coroutines.awaitCancellation
import kotlinx.coroutines.channels.Channel
import kotlinx.coroutines.delay
import kotlinx.coroutines.flow.Flow
import kotlinx.coroutines.flow.asFlow
import kotlinx.coroutines.flow.consumeAsFlow
import kotlinx.coroutines.flow.filterIsInstance
import kotlinx.coroutines.flow.first
import kotlinx.coroutines.flow.flow
import kotlinx.coroutines.flow.onCompletion
import kotlinx.coroutines.flow.onEach
import kotlinx.coroutines.flow.onStart
import kotlinx.coroutines.flow.toList
import kotlinx.coroutines.job
import kotlinx.coroutines.test.runTest
import org.junit.jupiter.api.Test
import kotlin.random.Random
import kotlin.test.assertEquals
import kotlin.test.assertFailsWith
import kotlin.test.assertIs
import kotlin.test.assertSame
import kotlin.test.assertTrue

class ImuJoinTest {
    @Test
    fun accelerationsAreInterpolatedToTheGyroscopesInstants() = runTest {
        val pairs = pair(listOf(10L, 12, 20, 27, 30), listOf(10L, 20, 30))
        assertEquals(listOf(10L, 12, 20, 27, 30), pairs.map { it.captureNanos })
        // acceleration(t) is linear in t, so the interpolation is it, exactly in these numbers
        for (pair in pairs) {
            assertEquals(rate(pair.captureNanos).x, pair.angularVelocity.x)
            val expected = acceleration(pair.captureNanos)
            assertEquals(expected.x, pair.linearAcceleration.x)
            assertEquals(expected.y, pair.linearAcceleration.y)
            assertEquals(expected.z, pair.linearAcceleration.z)
            assertEquals(pair.captureNanos, pair.linearAcceleration.captureNanos)
        }
    }

    @Test
    fun nothingIsExtrapolated() = runTest {
        val pairs = pair(listOf(1L, 9, 10, 15, 20, 21, 30), listOf(10L, 20))
        assertEquals(listOf(10L, 15, 20), pairs.map { it.captureNanos })
        assertEquals(emptyList(), pair(listOf(1L, 2, 3), emptyList()))
        assertEquals(emptyList(), pair(emptyList(), listOf(1L, 2)))
    }

    @Test
    fun anAccelerometerThatEndsEarlyLeavesTheRestOut() = runTest {
        assertEquals((0L..40).toList(), pair((0L..100).toList(), (0L..40).toList()).map { it.captureNanos })
    }

    @Test
    fun everyReadingOfEqualStampsIsPairedWithItsOwn() = runTest {
        val stamps = List(950) { 1_403_715_273_262_142_976 + it * 5_000_000L }
        val accelerations = stamps.map(::acceleration)
        val pairs = joinInertial(stamps.map(::rate).asFlow(), accelerations.asFlow()).toList()
        assertEquals(950, pairs.size)
        for ((pair, own) in pairs.zip(accelerations)) assertSame(own, assertIs<InertialSample>(pair).linearAcceleration)
    }

    @Test
    fun readingsOfTheGyroscopeAreNeverMerged() = runTest {
        assertEquals(listOf(5L, 5, 5, 6), pair(listOf(5L, 5, 5, 6), listOf(0L, 5, 10)).map { it.captureNanos })
    }

    @Test
    fun anyRatesOfTheTwoGiveEveryReadingBetweenThem() = runTest {
        for (seed in 1..100) {
            val random = Random(seed)
            val gyroscope = List(random.nextInt(200)) { random.nextLong(1_000) }.sorted()
            val accelerometer = List(random.nextInt(200)) { random.nextLong(1_000) }.distinct().sorted()
            val pairs = pair(gyroscope, accelerometer)
            val covered = gyroscope.filter { now -> accelerometer.any { it <= now } && accelerometer.any { it >= now } }
            assertEquals(covered, pairs.map { it.captureNanos }, "seed $seed")
            for (pair in pairs) assertEquals(acceleration(pair.captureNanos).x, pair.linearAcceleration.x, 1e-9)
        }
    }

    @Test
    fun readingsThatTheGyroscopeLostPass() = runTest {
        val lost = LostSamples(12, 3, DropReason.SOURCE_LATE)
        val gyroscope = flow {
            emit(rate(10))
            emit(lost)
            emit(rate(20))
        }
        val samples = joinInertial(gyroscope, listOf(10L, 20).map(::acceleration).asFlow()).toList()
        assertSame(lost, samples[1])
        assertEquals(3, samples.size)
    }

    @Test
    fun halvesThatHaveNoOtherAreCounted() = runTest {
        val gyroscope = (0L..5L).map(::rate).asFlow()
        val accelerometer = flow {
            emit(acceleration(1))
            emit(LostSamples(2, 2, DropReason.NO_BUFFER))
            emit(acceleration(3))
        }
        val samples = joinInertial(gyroscope, accelerometer).toList()
        assertEquals(listOf(1L, 2, 3), samples.filterIsInstance<InertialSample>().map { it.captureNanos })
        val lost = samples.filterIsInstance<LostSamples>().groupBy({ it.reason }, { it.count })
        assertEquals(2, lost.getValue(DropReason.NO_BUFFER).sum(), "what the accelerometer lost")
        assertEquals(2, lost.getValue(DropReason.SOURCE_LATE).sum(), "readings after the last acceleration")
    }

    @Test
    fun aPairIsDeliveredAsSoonAsBothSidesAreKnown() = runTest {
        val gyroscope = Channel<Sample>(Channel.UNLIMITED)
        val accelerometer = Channel<Sample>(Channel.UNLIMITED)
        joinInertial(gyroscope.consumeAsFlow(), accelerometer.consumeAsFlow()).test {
            accelerometer.send(acceleration(0))
            gyroscope.send(rate(5))
            expectNoEvents()
            accelerometer.send(acceleration(10))
            assertEquals(5, awaitItem().captureNanos)
            gyroscope.close()
            awaitComplete()
        }
    }

    @Test
    fun cancellingLeavesNoCoroutine() = runTest {
        var live = 0

        fun endless(sample: (Long) -> Sample): Flow<Sample> = flow {
            for (nanos in 0L..Long.MAX_VALUE) {
                emit(sample(nanos))
                delay(1)
            }
        }.onStart { live++ }.onCompletion { live-- }

        joinInertial(endless(::rate), endless(::acceleration)).onEach { assertEquals(2, live) }.first()
        assertEquals(0, live)
        assertTrue(coroutineContext.job.children.none())
    }

    @Test
    fun aSensorThatFailsFailsThePair() = runTest {
        val failing = flow<Sample> { throw IllegalStateException("unplugged") }
        val silent = flow<Sample> { awaitCancellation() }
        assertFailsWith<IllegalStateException> { joinInertial(silent, failing).toList() }
        assertFailsWith<IllegalStateException> { joinInertial(failing, silent).toList() }
        assertTrue(coroutineContext.job.children.none())
    }

    private suspend fun pair(gyroscope: List<Long>, accelerometer: List<Long>): List<InertialSample> =
        joinInertial(gyroscope.map(::rate).asFlow(), accelerometer.map(::acceleration).asFlow())
            .filterIsInstance<InertialSample>()
            .toList()

    private fun rate(nanos: Long) = VectorSample(nanos, nanos * 0.5, 0.0, 0.0)

    private fun acceleration(nanos: Long) = VectorSample(nanos, nanos * 0.25, 7.0, -2.0 * nanos)
}
