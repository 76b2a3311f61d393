package dev.ml2sensors.clock

import kotlinx.coroutines.async
import kotlinx.coroutines.test.currentTime
import kotlinx.coroutines.test.runCurrent
import kotlinx.coroutines.test.runTest
import org.junit.jupiter.api.Test
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
        assertEquals(HostClock.State.WAITING, clock.status.first)
        assertNull(clock.status.second)
        assertEquals(0, clock.rosNowNanos())
    }

    @Test
    fun sixteenExchangesMakeStamps() {
        exchange(15)
        assertEquals(HostClock.State.WAITING, clock.status.first)
        assertFalse(clock.stamps.isSet)
        exchange(1)
        assertEquals(HostClock.State.SYNCHRONISED, clock.status.first)
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
        assertTrue(clock.stamps.stampNanos(now) / 1_000_000 in before..System.currentTimeMillis())
        assertEquals(HostClock.State.WAITING, clock.status.first)
        clock.awaitStamps()
        assertEquals(5_000, currentTime, "once is enough")
        val wallOffset = clock.stamps.stampNanos(now) - now
        exchange(16, offset = wallOffset + 400_000)
        assertEquals(HostClock.State.SYNCHRONISED, clock.status.first)
        now += 10 * SECOND
        assertEquals(now + wallOffset + 400_000, clock.stamps.stampNanos(now), "the map follows the estimate")
    }

    @Test
    fun theMapIsSteeredOnceASecond() {
        exchange(16)
        exchange(10, offset = OFFSET + 300_000)
        val steered = now
        now += 20 * SECOND
        assertEquals(now + OFFSET, clock.stamps.stampNanos(now), "not within the second after $steered")
        exchange(1, offset = OFFSET + 300_000)
        now += 2 * SECOND
        assertEquals(now + OFFSET + 300_000, clock.stamps.stampNanos(now))
    }

    @Test
    fun theEstimateIsHeldWithoutALink() {
        exchange(16)
        clock.linkDown()
        assertEquals(HostClock.State.HOLDOVER, clock.status.first)
        now += SECOND
        assertEquals(now + OFFSET, clock.stamps.stampNanos(now))
        clock.linkUp()
        exchange(15)
        assertEquals(HostClock.State.HOLDOVER, clock.status.first)
        exchange(1)
        assertEquals(HostClock.State.SYNCHRONISED, clock.status.first)
    }

    @Test
    fun aLinkThatBreaksBeforeTheFirstEstimateLeavesItWaiting() {
        exchange(3)
        clock.linkDown()
        assertEquals(HostClock.State.WAITING, clock.status.first)
    }

    @Test
    fun whatWasMeasuredOnAnotherLinkNoLongerCounts() {
        exchange(16, roundTrip = 10)
        clock.linkDown()
        clock.linkUp()
        exchange(1, offset = OFFSET + 50, roundTrip = 1_000)
        assertEquals(OFFSET + 50, clock.status.second?.offsetNanos)
    }

    @Test
    fun aFrozenMapStaysWhileTheEstimateGoesOn() {
        exchange(16)
        clock.freeze()
        clock.freeze()
        assertEquals(HostClock.State.FROZEN, clock.status.first)
        now += 10 * SECOND
        exchange(20, offset = OFFSET + SECOND)
        now += 10 * SECOND
        assertEquals(now + OFFSET, clock.stamps.stampNanos(now))
        assertNotEquals(OFFSET, clock.status.second?.offsetNanos)
        clock.linkDown()
        assertEquals(HostClock.State.FROZEN, clock.status.first)
    }

    private fun exchange(count: Int, offset: Long = OFFSET, roundTrip: Long = 1_000) {
        repeat(count) {
            now += 9_000_000
            val t1 = now - roundTrip
            val t2 = t1 + roundTrip / 2 + offset
            clock.add(TimeExchange(t1, t2, t2, now))
        }
    }

    private companion object {
        const val SECOND = 1_000_000_000L
        const val OFFSET = 1_700_000_000_000_000_000L
    }
}
