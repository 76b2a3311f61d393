package dev.ml2sensors.pacing

import org.junit.jupiter.api.Test
import kotlin.test.assertEquals
import kotlin.test.assertFalse
import kotlin.test.assertNull
import kotlin.test.assertTrue

class RoundTripTest {
    @Test
    fun itTookNoLongerThanTheImagesBeforeIt() {
        val roundTrip = RoundTrip(startNanos = 1_000, writtenBytes = 200_000, acknowledgedBytes = 100_000)
        roundTrip.acknowledged(150_000, nowNanos = 1_500)
        assertTrue(roundTrip.isBehindImages)
        assertEquals(1_000, roundTrip.onPathNanos(2_000))
        roundTrip.acknowledged(200_000, nowNanos = 2_000)
        roundTrip.acknowledged(300_000, nowNanos = 3_000)
        assertFalse(roundTrip.isBehindImages)
        assertEquals(1_000, roundTrip.onPathNanos(9_000))
    }

    @Test
    fun itTellsNothingWithoutImagesBeforeIt() {
        val roundTrip = RoundTrip(startNanos = 1_000, writtenBytes = 200_000, acknowledgedBytes = 200_000)
        assertFalse(roundTrip.isBehindImages)
        assertNull(roundTrip.onPathNanos(9_000))
    }

    @Test
    fun twoSegmentsWhichMayBeAcknowledgedLateDoNotCount() {
        val last = RoundTrip(startNanos = 1_000, writtenBytes = 200_000, acknowledgedBytes = 197_080)
        assertNull(last.onPathNanos(9_000))
        val more = RoundTrip(startNanos = 1_000, writtenBytes = 200_000, acknowledgedBytes = 197_079)
        assertTrue(more.isBehindImages)
        more.acknowledged(197_080, nowNanos = 1_400)
        assertEquals(400, more.onPathNanos(9_000))
    }

    @Test
    fun itsTimeCountsWholeWhereNoKernelTellsWhatWasAcknowledged() {
        val roundTrip = RoundTrip(startNanos = 1_000, writtenBytes = 0, acknowledgedBytes = null)
        assertTrue(roundTrip.isBehindImages)
        assertEquals(8_000, roundTrip.onPathNanos(9_000))
    }
}
