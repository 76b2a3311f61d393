package dev.ml2sensors.capture

import org.junit.jupiter.api.Test
import kotlin.test.assertEquals
import kotlin.test.assertFalse
import kotlin.test.assertTrue

class PeriodicTimerTest {
    private var nanos = 50L
    private var suspended = 7L
    private val schedule = PeriodicTimer(periodNanos = 10, { nanos }, { suspended }) { nanos += it }

    @Test
    fun instantsAreAPeriodApart() {
        assertEquals(listOf(0 to 50L, 0 to 60L, 0 to 70L), List(3) { awaitNext() to nanos })
    }

    @Test
    fun instantsThatNobodyWaitedForAreCountedAndTheOthersStayWhereTheyWere() {
        awaitNext()
        nanos += 35
        assertEquals(2 to 85L, awaitNext() to nanos)
        assertEquals(0 to 90L, awaitNext() to nanos)
    }

    @Test
    fun beingLateByLessThanAPeriodMissesNone() {
        awaitNext()
        nanos += 19
        assertEquals(0 to 69L, awaitNext() to nanos)
        assertEquals(0 to 70L, awaitNext() to nanos)
    }

    @Test
    fun instantsOfASuspendedDeviceAreNotMissed() {
        awaitNext()
        nanos += 30_000
        suspended += 29_970
        assertEquals(2, awaitNext(), "30 of the 30,000 were awake")
        assertTrue(schedule.wasSuspended)
        assertEquals(0, awaitNext())
        assertFalse(schedule.wasSuspended)
    }

    private fun awaitNext() = schedule.awaitNext()
}
