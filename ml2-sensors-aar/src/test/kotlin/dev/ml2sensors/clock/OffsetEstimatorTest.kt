package dev.ml2sensors.clock

import org.junit.jupiter.api.Test
import kotlin.math.abs
import kotlin.random.Random
import kotlin.test.assertEquals
import kotlin.test.assertTrue

class OffsetEstimatorTest {
    @Test
    fun theExchangeWithTheLeastRoundTripDecides() {
        val estimator = OffsetEstimator()
        estimator.add(exchange(at = 0, out = 900, back = 100))
        val best = estimator.add(exchange(at = 10_000, out = 110, back = 90))
        assertEquals(OFFSET + 10, best.offsetNanos)
        assertEquals(200, best.roundTripNanos)
        assertEquals(100, best.uncertaintyNanos)
        val later = estimator.add(exchange(at = 20_000, out = 5_000, back = 300))
        assertEquals(OFFSET + 10, later.offsetNanos)
        assertEquals(25_300, later.atNanos)
    }

    @Test
    fun anOldExchangeGivesWayToANewOneThatIsHardlyWorse() {
        val estimator = OffsetEstimator()
        estimator.add(exchange(at = 0, out = 100, back = 100))
        val estimate = estimator.add(exchange(at = SECOND, out = 900, back = 1_000)) // 1 s may be 100 us of drift
        assertEquals(1_900, estimate.roundTripNanos)
    }

    @Test
    fun exchangesLeaveTheWindowAfterFiveSeconds() {
        val estimator = OffsetEstimator()
        estimator.add(exchange(at = 0, out = 10, back = 10))
        val slow = 2_000_000L
        assertEquals(20, estimator.add(exchange(at = 4 * SECOND, out = slow, back = slow)).roundTripNanos)
        assertEquals(2 * slow, estimator.add(exchange(at = 6 * SECOND, out = slow, back = slow)).roundTripNanos)
    }

    @Test
    fun uncertaintyGrowsAsTheBestExchangeAges() {
        val estimator = OffsetEstimator()
        val fresh = estimator.add(exchange(at = 0, out = 1_000, back = 1_000))
        val slow = 2_000_000L
        val aged = estimator.add(exchange(at = SECOND, out = slow, back = slow))
        val expected = fresh.uncertaintyNanos + (aged.atNanos - fresh.atNanos) / 10_000 // 100 ppm
        assertEquals(expected, aged.uncertaintyNanos)
    }

    @Test
    fun theErrorIsNeverAboveTheClaimedUncertainty() {
        for (seed in 1..50) {
            val random = Random(seed)
            val skewPpm = random.nextInt(-100, 101)
            val estimator = OffsetEstimator()
            var device = random.nextLong(SECOND)
            repeat(500) {
                device += random.nextLong(9_000_000, 60_000_000)
                val path = random.nextLong(10_000, 500_000)
                val out = path + jitter(random)
                val back = path + jitter(random)
                val work = random.nextLong(100_000)
                val t2 = host(device + out, skewPpm)
                val t3 = host(device + out + work, skewPpm)
                val end = device + out + work + back
                val estimate = estimator.add(TimeExchange(device, t2, t3, end))
                val error = abs(estimate.offsetNanos - (host(end, skewPpm) - end))
                // A nanosecond for each division that rounds, and what skew does within one exchange
                val slack = 3 + (end - device) / 10_000
                assertTrue(error <= estimate.uncertaintyNanos + slack, "seed $seed: $error")
                device = end
            }
        }
    }

    /** Mostly a little, at times milliseconds. */
    private fun jitter(random: Random): Long =
        if (random.nextInt(4) == 0) random.nextLong(5_000_000) else random.nextLong(50_000)

    private fun host(device: Long, skewPpm: Int): Long = device + OFFSET + device / 1_000_000 * skewPpm

    private fun exchange(at: Long, out: Long, back: Long): TimeExchange {
        val arrival = at + out + OFFSET
        return TimeExchange(at, arrival, arrival, at + out + back)
    }

    private companion object {
        const val SECOND = 1_000_000_000L
        const val OFFSET = 1_700_000_000_000_000_000L
    }
}
