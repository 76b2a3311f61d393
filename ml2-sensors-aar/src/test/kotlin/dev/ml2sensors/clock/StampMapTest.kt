package dev.ml2sensors.clock

import org.junit.jupiter.api.Test
import kotlin.math.abs
import kotlin.math.sign
import kotlin.random.Random
import kotlin.test.assertEquals
import kotlin.test.assertFailsWith
import kotlin.test.assertFalse
import kotlin.test.assertTrue

class StampMapTest {
    @Test
    fun stampsAreCaptureTimePlusOffset() {
        val map = StampMap()
        assertFalse(map.isSet)
        assertFailsWith<IllegalStateException> { map.stampNanos(1) }
        map.steerTo(offsetNanos = 1_000, nowNanos = 50)
        assertTrue(map.isSet)
        assertEquals(listOf(1_010L, 1_050L, 5_000_001_000L), listOf(10L, 50L, 5 * SECOND).map(map::stampNanos))
    }

    @Test
    fun aCaptureKeepsItsStampHoweverTheMapIsSteeredLater() {
        val random = Random(1)
        val map = StampMap().apply { steerTo(7 * SECOND, 0) }
        val stamps = HashMap<Long, Long>()
        var now = 0L
        repeat(60) {
            repeat(20) {
                now += random.nextLong(1, SECOND / 30)
                stamps[now] = map.stampNanos(now)
            }
            map.steerTo(7 * SECOND + random.nextLong(-SECOND, SECOND), now)
            for ((capture, stamp) in stamps) assertEquals(stamp, map.stampNanos(capture), "capture $capture")
        }
    }

    @Test
    fun stampsOfGrowingCapturesGrowWhateverTheSteering() {
        for (seed in 1..20) {
            val random = Random(seed)
            val map = StampMap().apply { steerTo(random.nextLong(), 0) }
            var now = 0L
            var last = map.stampNanos(0)
            repeat(5_000) {
                now += if (random.nextBoolean()) random.nextLong(2, 5) else random.nextLong(2, SECOND)
                if (random.nextInt(5) == 0) map.steerTo(last - now + random.nextLong(-MILLI, MILLI), now)
                if (random.nextInt(50) == 0) map.steerTo(random.nextLong(), now - random.nextLong(SECOND))
                val stamp = map.stampNanos(now)
                assertTrue(stamp > last, "seed $seed: $stamp after $last")
                last = stamp
            }
        }
    }

    @Test
    fun steeringReachesTheOffsetAndNotFasterThan500Ppm() {
        for (error in listOf(SECOND / 1000, -SECOND / 1000, 123_456L, -7L)) {
            val map = StampMap().apply { steerTo(0, 0) }
            map.stampNanos(SECOND)
            map.steerTo(error, SECOND)
            var last = 0L
            for (tenths in 11..50) {
                val capture = tenths * SECOND / 10
                val offset = map.stampNanos(capture) - capture
                assertTrue(abs(offset - last) <= SECOND / 10 / 2_000 + 1, "$offset after $last")
                last = offset
            }
            assertEquals(error, last)
        }
    }

    @Test
    fun capturesLaterThanTheSteeringKeepWhatWasStampedBefore() {
        val map = StampMap().apply { steerTo(0, 0) }
        val ahead = map.stampNanos(10 * SECOND)
        map.steerTo(-SECOND, SECOND)
        assertEquals(ahead, map.stampNanos(10 * SECOND))
        assertEquals(5 * SECOND, map.stampNanos(5 * SECOND))
        assertTrue(map.stampNanos(11 * SECOND) < 11 * SECOND)
    }

    @Test
    fun aHostThatStepsByDecadesIsSlewedTowardsAsAnyOther() {
        for (step in listOf(
            50L * 365 * 86_400 * SECOND,
            -50L * 365 * 86_400 * SECOND,
            Long.MAX_VALUE,
            Long.MIN_VALUE,
        )) {
            val map = StampMap().apply { steerTo(0, 0) }
            map.steerTo(step, SECOND)
            val capture = 3 * SECOND + 1
            assertEquals(step.sign * SECOND / 1000, map.stampNanos(capture) - capture)
        }
    }

    @Test
    fun freezingKeepsIntervalsExact() {
        val map = StampMap().apply { steerTo(1_000, 0) }
        map.steerTo(9_000_000, SECOND)
        map.freeze(2 * SECOND)
        map.steerTo(-SECOND, 3 * SECOND)
        val constant = map.stampNanos(2 * SECOND) - 2 * SECOND
        val random = Random(3)
        repeat(1_000) {
            val capture = random.nextLong(-SECOND, 1_000 * SECOND)
            assertEquals(capture + constant, map.stampNanos(capture))
        }
    }

    private companion object {
        const val MILLI = 1_000_000L
        const val SECOND = 1_000_000_000L
    }
}
