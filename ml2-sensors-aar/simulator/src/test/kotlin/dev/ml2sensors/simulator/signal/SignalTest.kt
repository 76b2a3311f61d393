package dev.ml2sensors.simulator.signal

import dev.ml2sensors.source.DeviceClock
import dev.ml2sensors.source.DropReason
import dev.ml2sensors.source.LostSamples
import dev.ml2sensors.source.Sample
import dev.ml2sensors.source.ScalarSample
import kotlinx.coroutines.ExperimentalCoroutinesApi
import kotlinx.coroutines.Job
import kotlinx.coroutines.delay
import kotlinx.coroutines.flow.collect
import kotlinx.coroutines.flow.take
import kotlinx.coroutines.flow.toList
import kotlinx.coroutines.launch
import kotlinx.coroutines.test.TestScope
import kotlinx.coroutines.test.currentTime
import kotlinx.coroutines.test.runTest
import org.junit.jupiter.api.Test
import java.math.BigInteger
import kotlin.random.Random
import kotlin.test.assertEquals
import kotlin.test.assertTrue
import kotlin.time.Duration.Companion.milliseconds

@OptIn(ExperimentalCoroutinesApi::class)
class SignalTest {
    @Test
    fun sampleTimesAreExactInstantsRoundedDown() {
        val random = Random(1)
        repeat(10_000) {
            val rate = random.nextInt(1, 1000)
            val tick = random.nextLong(4_000_000_000)
            val exact = BigInteger.valueOf(tick) * BigInteger.valueOf(1_000_000_000) / BigInteger.valueOf(rate.toLong())
            assertEquals(17 + exact.toLong(), SampleTimes(17, rate).nanos(tick))
        }
    }

    @Test
    fun theLastTickIsTheNewestOneNotAfterATime() {
        val random = Random(2)
        repeat(10_000) {
            val ticks = SampleTimes(random.nextLong(1_000_000), random.nextInt(1, 1000))
            val nanos = random.nextLong(1_000_000, 10_000_000_000)
            val last = ticks.lastTickAt(nanos)
            assertTrue(ticks.nanos(last) <= nanos && nanos < ticks.nanos(last + 1))
            assertEquals(last, ticks.lastTickAt(ticks.nanos(last)))
        }
    }

    @Test
    fun samplesComeInOrderAfterTheirCaptureTimes() = runTest {
        val arrivals = mutableListOf<Pair<Long, Long>>()
        counter(30).samples(clock, startNanos = 100_000_000, Job()).take(60).collect {
            arrivals += it.captureNanos to clock.nowNanos()
        }
        assertEquals(List(60) { SampleTimes(100_000_000, 30).nanos(it.toLong()) }, arrivals.map { it.first })
        assertTrue(arrivals.all { (capture, arrival) -> arrival - capture in 0..1_000_000 })
    }

    @Test
    fun aLateCollectorStillGetsSamplesUpTo250MillisOld() = runTest {
        val samples = mutableListOf<Sample>()
        counter(200).samples(clock, 0, Job()).take(80).collect {
            samples += it
            if (samples.size == 10) delay(250.milliseconds)
        }
        assertEquals(List(80) { it.toDouble() }, samples.map { (it as ScalarSample).value })
    }

    @Test
    fun aCollectorThatIsTooLateLosesSamplesAndContinuesWithTheNewest() = runTest {
        val samples = mutableListOf<Sample>()
        counter(10).samples(clock, 0, Job()).take(8).collect {
            samples += it
            if (samples.size == 3) delay(470.milliseconds)
        }
        val lost = samples.filterIsInstance<LostSamples>().single()
        assertEquals(300_000_000, lost.captureNanos)
        assertEquals(3, lost.count)
        assertEquals(DropReason.SOURCE_LATE, lost.reason)
        val numbers = samples.filterIsInstance<ScalarSample>().map { it.value.toInt() }
        assertEquals(listOf(0, 1, 2, 6, 7, 8, 9), numbers)
    }

    @Test
    fun aSensorStartedLaterUsesTheSameSampleTimesAndCountsFromZero() = runTest {
        delay(1_010.milliseconds)
        val samples = counter(30).samples(clock, 0, Job()).take(3).toList()
        assertEquals(List(3) { SampleTimes(0, 30).nanos(31L + it) }, samples.map { it.captureNanos })
        assertEquals(listOf(0.0, 1.0, 2.0), samples.map { (it as ScalarSample).value })
    }

    @Test
    fun cancellationDoesNotWaitForTheNextSample() = runTest {
        val end = Job()
        val reading = launch { counter(1).samples(clock, 0, end).collect() }
        delay(2_300.milliseconds)
        end.cancel()
        reading.join()
        assertEquals(2_300, currentTime)
    }
}

private fun counter(rateHz: Int) = Signal(rateHz) { ScalarSample(it.nanos, it.number.toDouble()) }

/** The clock of virtual time. */
@OptIn(ExperimentalCoroutinesApi::class)
internal val TestScope.clock get() = DeviceClock { testScheduler.currentTime * 1_000_000 }
