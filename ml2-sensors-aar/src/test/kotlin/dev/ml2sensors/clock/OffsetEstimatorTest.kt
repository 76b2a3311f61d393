package dev.ml2sensors.clock

import org.junit.jupiter.api.Test
import kotlin.math.abs
import kotlin.random.Random
import kotlin.test.assertEquals
import kotlin.test.assertTrue

class OffsetEstimatorTest {
    private val estimator = OffsetEstimator()

    @Test
    fun theLeastDelayOfEachDirectionDecides() {
        estimator.add(exchange(at = 0, out = 100, back = 900))
        val best = estimator.add(exchange(at = 10_000, out = 800, back = 80))
        assertEquals(OFFSET + 10, best.offsetNanos)
        assertEquals(880, best.roundTripNanos)
        assertEquals(10_880, best.atNanos)
    }

    @Test
    fun uncertaintyIsNeverBelowHalfTheLeastRoundTrip() {
        estimator.add(exchange(at = 0, out = 100, back = 900))
        val best = estimator.add(exchange(at = 10_000, out = 800, back = 80))
        // One way each, the bounds alone would allow 90 ns
        assertTrue(best.uncertaintyNanos in 440..442, "${best.uncertaintyNanos}")
    }

    @Test
    fun skewIsFoundAndCarriedOn() {
        for (ppm in listOf(0, 50, -50, 300)) {
            val estimator = OffsetEstimator()
            val estimates = (0..600).map { estimator.add(exchange(it * 50 * MILLI, 40_000, 40_000, ppm = ppm)) }
            val latest = estimates.last()
            assertTrue(abs(latest.skewPpb - ppm * 1_000) <= 1_000, "$ppm ppm: ${latest.skewPpb} ppb")
            val later = latest.atNanos + 100 * SECOND
            val error = abs(latest.offsetNanos(later) - OFFSET - later / 1_000_000 * ppm)
            assertTrue(error <= latest.uncertaintyNanos(later), "$ppm ppm: $error of ${latest.uncertaintyNanos(later)}")
        }
    }

    @Test
    fun anOldBoundLoosensByWhatTheRateIsNotKnownTo() {
        val fresh = estimator.add(exchange(at = 0, out = 1_000, back = 1_000))
        val slow = 2 * MILLI
        val aged = estimator.add(exchange(at = SECOND, out = slow, back = slow))
        // 500 ppm that a host can be slewed by, and 1 ppm of wander; for once a second of each
        val growth = aged.uncertaintyNanos - fresh.uncertaintyNanos
        assertTrue(growth in 502_000..506_000, "$growth ns in ${aged.atNanos - fresh.atNanos}")
        assertEquals(fresh.driftPpb, 501_001)
    }

    @Test
    fun exchangesOfBeforeAnOutageStillBind() {
        repeat(100) { estimator.add(exchange(at = it * 50 * MILLI, out = 40_000, back = 40_000)) }
        val after = estimator.add(exchange(at = 15 * SECOND, out = 4 * MILLI, back = 40_000))
        assertTrue(abs(after.offsetNanos - OFFSET) < 100 * MICRO, "${after.offsetNanos - OFFSET} ns")
        assertTrue(after.uncertaintyNanos < MILLI, "${after.uncertaintyNanos} ns of a round trip of 4 ms")
    }

    @Test
    fun twoExchangesThatContradictAreSetAsideAndThreeAreAStep() {
        repeat(20) { estimator.add(exchange(at = it * 50 * MILLI, out = 1_000, back = 1_000)) }
        val step = 10 * MILLI
        fun stepped(at: Long) = estimator.add(exchange(at, out = 1_000, back = 1_000, step = step))
        assertEquals(OFFSET, stepped(1_000 * MILLI).offsetNanos)
        assertEquals(OFFSET, stepped(1_050 * MILLI).offsetNanos)
        assertEquals(0, estimator.steps)
        assertEquals(OFFSET + step, stepped(1_100 * MILLI).offsetNanos)
        assertEquals(1, estimator.steps)
    }

    @Test
    fun contradictionsMoreThanASecondApartAreNoStep() {
        repeat(100) {
            val step = if (it % 11 == 10) SECOND else 0
            estimator.add(exchange(at = it * 50 * MILLI, out = 1_000, back = 1_000, step = step))
        }
        assertEquals(0, estimator.steps)
    }

    @Test
    fun aHostThatIsSlewedIsFollowedAndNotTakenForOneThatSteps() {
        var truth = 0L
        var worst = 0L
        for (i in 0..1_200) {
            if (i > 200) truth += 500 * 50 // 500 ppm
            val estimate = estimator.add(exchange(at = i * 50 * MILLI, out = 40_000, back = 40_000, step = truth))
            if (i > 220) worst = maxOf(worst, abs(estimate.offsetNanos - OFFSET - truth))
        }
        assertEquals(0, estimator.steps)
        assertTrue(worst < 500 * MICRO, "$worst ns")
    }

    @Test
    fun theErrorIsNeverAboveTheClaimedUncertainty() {
        for (seed in 1..60) {
            val random = Random(seed)
            val ppm = random.nextInt(-100, 101)
            val estimator = OffsetEstimator()
            val path = random.nextLong(10_000, 2 * MILLI)
            var at = random.nextLong(SECOND)
            repeat(500) {
                at += random.nextLong(9 * MILLI, 60 * MILLI)
                val exchange = exchange(at, path + jitter(random), path + jitter(random), ppm)
                val estimate = estimator.add(exchange)
                val error = abs(estimate.offsetNanos - offset(exchange.t4, ppm))
                assertTrue(error <= estimate.uncertaintyNanos, "seed $seed: $error of ${estimate.uncertaintyNanos}")
                assertTrue(estimate.uncertaintyNanos >= estimate.roundTripNanos / 2)
                at = exchange.t4
            }
            assertEquals(0, estimator.steps, "seed $seed")
        }
    }

    /** Mostly a little, at times milliseconds. */
    private fun jitter(random: Random): Long =
        if (random.nextInt(4) == 0) random.nextLong(5 * MILLI) else random.nextLong(50_000)

    private fun offset(at: Long, ppm: Int) = OFFSET + at / 1_000_000 * ppm

    private fun exchange(at: Long, out: Long, back: Long, ppm: Int = 0, step: Long = 0): TimeExchange {
        val arrival = at + out
        val host = arrival + offset(arrival, ppm) + step
        return TimeExchange(at, host, host, arrival + back)
    }

    private companion object {
        const val OFFSET = 1_700_000_000 * SECOND
    }
}
