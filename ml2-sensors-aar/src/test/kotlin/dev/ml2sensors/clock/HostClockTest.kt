package dev.ml2sensors.clock

import kotlinx.coroutines.async
import kotlinx.coroutines.test.currentTime
import kotlinx.coroutines.test.runCurrent
import kotlinx.coroutines.test.runTest
import org.junit.jupiter.api.Test
import kotlin.math.abs
import kotlin.test.assertEquals
import kotlin.test.assertFalse
import kotlin.test.assertNotEquals
import kotlin.test.assertNull
import kotlin.test.assertTrue

class HostClockTest {
    private var now = 100 * SECOND
    private val clock = HostClock { now }

    @Test
    fun nothingIsKnownBeforeTheFirstExchange() {
        assertEquals(HostClock.State.WAITING, clock.status.state)
        assertEquals(0, clock.status.uncertaintyNanos)
        assertEquals(0, clock.rosNowNanos())
    }

    @Test
    fun sixteenExchangesMakeStamps() {
        exchange(15)
        assertEquals(HostClock.State.WAITING, clock.status.state)
        assertFalse(clock.stamps.isSet)
        exchange(1)
        assertEquals(HostClock.State.SYNCHRONISED, clock.status.state)
        assertEquals(now + OFFSET, clock.stamps.stampNanos(now))
        assertEquals(now + OFFSET, clock.rosNowNanos())
    }

    @Test
    fun stampsAreAwaitedNoLongerThanTheFirstEstimate() = runTest {
        val waiting = async { clock.awaitStamps() }
        runCurrent()
        assertFalse(waiting.isCompleted)
        exchange(16)
        waiting.await()
        assertEquals(0, currentTime)
        assertEquals(now + OFFSET, clock.stamps.stampNanos(now))
    }

    @Test
    fun afterFiveSecondsTheDevicesWallClockServesUntilThereIsAnEstimate() = runTest {
        val before = System.currentTimeMillis()
        clock.awaitStamps()
        assertEquals(5_000, currentTime)
        assertTrue(stamp() / MILLI in before..System.currentTimeMillis())
        assertEquals(HostClock.State.WAITING, clock.status.state)
        clock.awaitStamps()
        assertEquals(5_000, currentTime, "once is enough")
        exchange(16)
        assertEquals(HostClock.State.SYNCHRONISED, clock.status.state)
        now += MILLI
        assertEquals(now + OFFSET, stamp(), "the map follows the estimate")
        assertEquals(1, clock.status.epoch)
        assertEquals(0, clock.status.steps, "the host's clock did not jump")
    }

    @Test
    fun uncertaintyHoldsWhatTheMapHasNotYetSlewed() {
        exchange(16)
        exchange(40, offset = OFFSET + 2 * MILLI)
        val status = clock.status
        assertEquals(0, status.steps, "2 ms are slewed")
        val error = abs(stamp() - now - OFFSET - 2 * MILLI)
        assertTrue(error > MILLI, "$error")
        assertTrue(status.uncertaintyNanos >= error + 500, "${status.uncertaintyNanos} ns for $error")
    }

    @Test
    fun aStepIsFollowedAfterThreeExchangesAndCounted() {
        exchange(30)
        exchange(2, offset = OFFSET + SECOND)
        assertEquals(0, clock.status.steps)
        exchange(1, offset = OFFSET + SECOND)
        assertEquals(1, clock.status.steps)
        assertEquals(1, clock.status.epoch)
        now += MILLI
        assertEquals(now + OFFSET + SECOND, stamp())
    }

    @Test
    fun aStepBackWithholdsStampsWithoutANewEpoch() {
        exchange(30)
        exchange(3, offset = OFFSET - SECOND)
        now += MILLI
        assertEquals(null, clock.stamps.stampNanos(now))
        now += SECOND
        assertEquals(now + OFFSET - SECOND, stamp())
        assertEquals(listOf(1L, 0L), clock.status.run { listOf(steps, epoch) })
    }

    @Test
    fun theEstimateIsHeldWithoutALinkAndGetsLessCertain() {
        exchange(30)
        clock.endSession()
        assertEquals(HostClock.State.HOLDOVER, clock.status.state)
        val before = clock.status.uncertaintyNanos
        now += 100 * SECOND
        assertEquals(now + OFFSET, stamp())
        val growth = clock.status.uncertaintyNanos - before
        assertTrue(growth in 100 * MICRO..100 * MILLI, "1 ppm at least, 1000 at most: $growth ns")
        exchange(1)
        assertEquals(HostClock.State.SYNCHRONISED, clock.status.state)
        assertTrue(clock.status.uncertaintyNanos <= before)
    }

    @Test
    fun aSilentTimeLaneIsHoldoverToo() {
        exchange(16)
        now += SECOND
        assertEquals(HostClock.State.SYNCHRONISED, clock.status.state)
        now += 1
        assertEquals(HostClock.State.HOLDOVER, clock.status.state)
    }

    @Test
    fun aLinkThatBreaksBeforeTheFirstEstimateLeavesItWaiting() {
        exchange(3)
        clock.endSession()
        assertEquals(HostClock.State.WAITING, clock.status.state)
    }

    @Test
    fun aFrozenMapStaysWhileTheEstimateGoesOn() {
        exchange(16)
        clock.freeze()
        clock.freeze()
        assertEquals(HostClock.State.FROZEN, clock.status.state)
        now += 10 * SECOND
        exchange(20, offset = OFFSET + SECOND)
        now += 10 * SECOND
        assertEquals(now + OFFSET, clock.stamps.stampNanos(now))
        assertNotEquals(OFFSET, clock.status.offsetNanos)
        clock.endSession()
        assertEquals(HostClock.State.FROZEN, clock.status.state)
    }

    @Test
    fun theWayToTheHostIsKnownApartFromTheWayBack() {
        val t1 = now + SECOND
        val slowBack = TimeExchange(t1, t1 + 300 + OFFSET, t1 + 300 + OFFSET, t1 + 50 * MILLI)
        assertNull(clock.thereNanos(slowBack))
        exchange(16)
        assertEquals(300, clock.thereNanos(slowBack))
        exchange(1, roundTrip = 20 * MILLI)
        assertEquals(300, clock.thereNanos(slowBack))
        now += 100_000 * SECOND
        val late = TimeExchange(now, now + OFFSET, now + OFFSET, now)
        assertNull(clock.thereNanos(late), "the estimate is too old to tell")
    }

    @Test
    fun theWayToTheHostIsKnownOnLongPathsToo() {
        exchange(30, roundTrip = 60 * MILLI)
        val queued = TimeExchange(now, now + 40 * MILLI + OFFSET, now + 40 * MILLI + OFFSET, now + 70 * MILLI)
        val there = checkNotNull(clock.thereNanos(queued))
        assertTrue(abs(there - 40 * MILLI) < MICRO, "$there ns")
    }

    private fun stamp(): Long = checkNotNull(clock.stamps.stampNanos(now))

    private fun exchange(count: Int, offset: Long = OFFSET, roundTrip: Long = 1_000) {
        repeat(count) {
            now += 9 * MILLI
            val t1 = now - roundTrip
            val t2 = t1 + roundTrip / 2 + offset
            clock.add(TimeExchange(t1, t2, t2, now))
        }
    }

    private companion object {
        const val OFFSET = 1_700_000_000 * SECOND
    }
}
