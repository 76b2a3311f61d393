package dev.ml2sensors.pacing

import org.junit.jupiter.api.Test
import org.junit.jupiter.params.ParameterizedTest
import org.junit.jupiter.params.provider.CsvSource
import kotlin.random.Random
import kotlin.test.assertEquals
import kotlin.test.assertTrue

class AdaptedStreamTest {
    @ParameterizedTest
    @CsvSource("30, 15", "30, 10", "30, 1", "60, 15", "50, 15", "25, 10", "5, 1")
    fun aLoweredRateIsEven(capturedHz: Int, rateHz: Int) {
        val random = Random(capturedHz * 100 + rateHz)
        val stream = AdaptedStream("any", ImageSetting(capturedHz, quality = null))
        stream.present = ImageSetting(rateHz, quality = null)
        val period = SECOND / capturedHz
        val captures = List(capturedHz * SECONDS) { START + it * period + random.nextLong(-period / 10, period / 10) }
        val admitted = captures.filter(stream::admits)
        assertEquals(rateHz * SECONDS.toDouble(), admitted.size.toDouble(), absoluteTolerance = 1.0)
        val pauses = admitted.zipWithNext { before, next -> next - before }
        assertTrue(pauses.all { it in SECOND / rateHz - period..SECOND / rateHz + period }, "$pauses")
    }

    @Test
    fun theConfiguredRateAdmitsEverything() {
        val stream = AdaptedStream("any", ImageSetting(30, quality = null))
        assertTrue((1..100).all { stream.admits(START + it * 1_000_000L) })
    }

    @Test
    fun aPauseOfTheCameraDelaysNothing() {
        val stream = AdaptedStream("any", ImageSetting(30, quality = null))
        stream.present = ImageSetting(10, quality = null)
        assertTrue(stream.admits(START))
        assertTrue(stream.admits(START + 60 * SECOND))
        assertEquals(listOf(false, false, true), (1..3).map { stream.admits(START + 60 * SECOND + it * SECOND / 30) })
    }

    @Test
    fun aHigherRateHoldsFromTheNextImage() {
        val stream = AdaptedStream("any", ImageSetting(30, quality = null))
        stream.present = ImageSetting(1, quality = null)
        assertTrue(stream.admits(START))
        stream.present = ImageSetting(10, quality = null)
        assertTrue(stream.admits(START + SECOND / 10))
    }

    @Test
    fun sizesFollowTheStreamTable() {
        val stream = AdaptedStream("any", ImageSetting(30, quality = 80))
        val low = ImageSetting(15, quality = 40)
        stream.published(100_000, stream.configured)
        assertEquals(3_000_000.0, stream.bytesPerSecond(stream.configured), absoluteTolerance = 1.0)
        assertEquals(15 * 50_000.0, stream.bytesPerSecond(low), absoluteTolerance = 1.0)
        repeat(100) { stream.published(40_000, low) }
        assertEquals(15 * 40_000.0, stream.bytesPerSecond(low), absoluteTolerance = 1.0)
    }

    private companion object {
        const val SECOND = 1_000_000_000L
        const val SECONDS = 20

        /** As on a device that was started a while ago. */
        const val START = 1_234 * SECOND
    }
}
