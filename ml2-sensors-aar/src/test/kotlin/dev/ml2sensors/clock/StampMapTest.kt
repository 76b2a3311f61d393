package dev.ml2sensors.clock

import dev.ml2sensors.source.DropReason
import org.junit.jupiter.api.Test
import kotlin.math.abs
import kotlin.random.Random
import kotlin.test.assertEquals
import kotlin.test.assertFailsWith
import kotlin.test.assertFalse
import kotlin.test.assertNull
import kotlin.test.assertTrue

class StampMapTest {
    @Test
    fun stampsAreCaptureTimePlusOffset() {
        val map = StampMap { LATE }
        assertFalse(map.isSet)
        assertFailsWith<IllegalStateException> { map.stampNanos(1) }
        map.steerTo(offsetNanos = 1_000, nowNanos = 50)
        assertTrue(map.isSet)
        assertEquals(listOf(1_010L, 1_050L, 5_000_001_000L), listOf(10L, 50L, 5 * SECOND).map(map::stampNanos))
    }

    @Test
    fun theOffsetGrowsBySkew() {
        val map = map(offset = 1_000)
        map.steerTo(1_000, SECOND, skewPpb = -50_000)
        assertOffset(1_000 - 500_000, map, 11 * SECOND + 1)
    }

    @Test
    fun aCaptureKeepsItsStampHoweverTheMapIsSteeredLater() {
        val random = Random(1)
        val map = map(offset = 7 * SECOND)
        val stamps = HashMap<Long, Long?>()
        var now = 0L
        repeat(60) {
            repeat(20) {
                now += random.nextLong(1, SECOND / 30)
                stamps[now] = map.stampNanos(now)
            }
            map.steerTo(7 * SECOND + random.nextLong(-3 * SECOND, 3 * SECOND), now)
            for ((capture, stamp) in stamps) assertEquals(stamp, map.stampNanos(capture), "capture $capture")
        }
        assertTrue(null in stamps.values, "some were withheld")
    }

    @Test
    fun withinAnEpochStampsGrowWhateverTheSteering() {
        var epochs = 0L
        for (seed in 1..20) {
            val random = Random(seed)
            val map = map(random.nextLong(-SECOND, SECOND))
            var now = 0L
            var epoch = 0L
            var last = Long.MIN_VALUE
            var offset = 0L
            repeat(5_000) {
                now += if (random.nextBoolean()) random.nextLong(2, 5) else random.nextLong(2, SECOND)
                val skewPpb = random.nextLong(-500_000, 500_001)
                val before = now - 1
                if (random.nextInt(5) == 0) map.steerTo(offset + random.nextLong(-MILLI, MILLI), before, skewPpb)
                if (random.nextInt(50) == 0) map.steerTo(offset - random.nextLong(2 * SECOND), before, skewPpb)
                if (random.nextInt(500) == 0) map.steerTo(random.nextLong(SECOND), before)
                val stamp = map.stampNanos(now)
                if (map.epoch != epoch) last = Long.MIN_VALUE
                epoch = map.epoch
                if (stamp == null) return@repeat
                assertTrue(stamp > last, "seed $seed: $stamp after $last")
                last = stamp
                offset = stamp - now
            }
            epochs += epoch
        }
        assertTrue(epochs > 0)
    }

    @Test
    fun steeringReachesTheOffsetAndNotFasterThan500Ppm() {
        for (error in listOf(MILLI, -MILLI, 123_456L, -7L)) {
            val map = map(offset = 0)
            map.stampNanos(SECOND)
            map.steerTo(error, SECOND)
            var last = 0L
            for (tenths in 11..50) {
                val capture = tenths * SECOND / 10
                val offset = checkNotNull(map.stampNanos(capture)) - capture
                assertTrue(abs(offset - last) <= SECOND / 10 / 2_000 + 1, "$offset after $last")
                last = offset
            }
            assertEquals(error, last)
            assertEquals(0, map.epoch)
        }
    }

    @Test
    fun capturesLaterThanTheSteeringKeepWhatWasStampedBefore() {
        val map = map(offset = 0)
        assertEquals(10 * SECOND, map.stampNanos(10 * SECOND))
        map.steerTo(-MILLI, SECOND)
        assertOffset(0, map, 10 * SECOND)
        assertOffset(0, map, 5 * SECOND)
        assertTrue(checkNotNull(map.stampNanos(11 * SECOND)) < 11 * SECOND)
    }

    @Test
    fun afterAStepBackNothingIsStampedUntilRosTimeHasPassedTheLastStamp() {
        for (step in listOf(6 * MILLI, SECOND, 2 * SECOND)) {
            val map = map(offset = 0)
            map.stampNanos(SECOND)
            map.steerTo(-step, SECOND)
            assertNull(map.stampNanos(SECOND + 2))
            assertNull(map.stampNanos(SECOND + step))
            assertEquals(SECOND + 1, map.stampNanos(SECOND + step + 1))
            assertOffset(0, map, SECOND)
            assertEquals(0, map.epoch)
        }
    }

    @Test
    fun whatIsSteeredWhileStampsAreWithheldDoesNotLetThemGoEarlier() {
        val map = map(offset = 0)
        map.stampNanos(SECOND)
        map.steerTo(-SECOND, SECOND)
        assertNull(map.stampNanos(SECOND + SECOND / 2))
        map.steerTo(-SECOND + 100, SECOND + SECOND / 2)
        assertNull(map.stampNanos(2 * SECOND - 1_000))
        map.steerTo(-2 * SECOND, 2 * SECOND - 1_000)
        assertNull(map.stampNanos(3 * SECOND))
        assertEquals(SECOND + 1, map.stampNanos(3 * SECOND + 1))
    }

    @Test
    fun anyOtherStepBeginsANewEpochAtOnce() {
        for (step in listOf(-2 * SECOND - 1, 6 * MILLI, SECOND, DECADES, -DECADES)) {
            val map = map(offset = 0)
            map.stampNanos(SECOND)
            map.steerTo(step, SECOND)
            assertOffset(step, map, SECOND + 1)
            assertOffset(0, map, SECOND)
            assertEquals(1, map.epoch, "step by $step ns")
        }
    }

    @Test
    fun aCaptureMoreThanASecondAheadHasNoStampAndStopsNoSteering() {
        val map = StampMap { SECOND }.apply { steerTo(0, 0) }
        for (capture in listOf(2 * SECOND + 1, DECADES, Long.MAX_VALUE)) {
            assertNull(map.stampNanos(capture))
            assertEquals(DropReason.FUTURE_CAPTURE, map.lossReason(capture))
        }
        assertEquals(2 * SECOND, map.stampNanos(2 * SECOND))
        map.steerTo(DECADES, SECOND)
        assertOffset(0, map, 2 * SECOND)
        assertEquals(1, map.epoch)
    }

    @Test
    fun freezingKeepsIntervalsExact() {
        val map = map(offset = 1_000)
        map.steerTo(4 * MILLI, SECOND, skewPpb = 50_000)
        map.freeze(2 * SECOND)
        map.steerTo(-SECOND, 3 * SECOND)
        val constant = checkNotNull(map.stampNanos(2 * SECOND)) - 2 * SECOND
        val random = Random(3)
        repeat(1_000) {
            val capture = random.nextLong(-SECOND, 1_000 * SECOND)
            assertEquals(capture + constant, map.stampNanos(capture))
        }
    }

    private fun map(offset: Long) = StampMap { LATE }.apply { steerTo(offset, 0) }

    private fun assertOffset(expected: Long, map: StampMap, captureNanos: Long) =
        assertEquals(captureNanos + expected, map.stampNanos(captureNanos))

    private companion object {
        /** Later than any capture. */
        const val LATE = Long.MAX_VALUE / 2
        const val DECADES = 50L * 365 * 86_400 * SECOND
    }
}
