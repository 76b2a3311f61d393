package dev.ml2sensors.app.screen

import org.junit.jupiter.api.Test
import kotlin.test.assertEquals

class RateMeterTest {
    private val rateMeter = RateMeter()

    @Test
    fun aRateIsTheNumberOfMessagesPerSecondBetweenTwoUpdates() {
        assertEquals(emptyMap(), rateMeter.update(mapOf("depth" to 100L), nowMillis = 1_000))
        assertEquals(
            mapOf("depth" to 30.0),
            rateMeter.update(mapOf("depth" to 160L), nowMillis = 3_000),
        )
        assertEquals(
            mapOf("depth" to 0.0),
            rateMeter.update(mapOf("depth" to 160L), nowMillis = 4_000),
        )
    }

    @Test
    fun aNewOrRestartedStreamHasNoRateYet() {
        rateMeter.update(mapOf("depth" to 100L), nowMillis = 1_000)
        val counts = mapOf("depth" to 5L, "gaze" to 5L)
        assertEquals(emptyMap(), rateMeter.update(counts, nowMillis = 2_000))
    }

    @Test
    fun twoUpdatesAtTheSameTimeGiveNoRate() {
        rateMeter.update(mapOf("depth" to 100L), nowMillis = 1_000)
        assertEquals(emptyMap(), rateMeter.update(mapOf("depth" to 101L), nowMillis = 1_000))
    }
}
