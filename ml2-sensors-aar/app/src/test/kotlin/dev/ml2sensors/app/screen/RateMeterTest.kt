package dev.ml2sensors.app.screen

import dev.ml2sensors.app.status.streamStatus
import org.junit.jupiter.api.Test
import kotlin.test.assertEquals

class RateMeterTest {
    private val rateMeter = RateMeter()

    @Test
    fun aRateIsTheNumberOfMessagesPerSecondBetweenTwoUpdates() {
        assertEquals(emptyMap(), rateMeter.update(listOf(streamStatus("depth", produced = 100)), nowMillis = 1_000))
        assertEquals(
            mapOf("depth" to 30.0),
            rateMeter.update(listOf(streamStatus("depth", produced = 160)), nowMillis = 3_000),
        )
        assertEquals(
            mapOf("depth" to 0.0),
            rateMeter.update(listOf(streamStatus("depth", produced = 160)), nowMillis = 4_000),
        )
    }

    @Test
    fun aNewOrRestartedStreamHasNoRateYet() {
        rateMeter.update(listOf(streamStatus("depth", produced = 100)), nowMillis = 1_000)
        val streams = listOf(streamStatus("depth", produced = 5), streamStatus("gaze", produced = 5))
        assertEquals(emptyMap(), rateMeter.update(streams, nowMillis = 2_000))
    }

    @Test
    fun twoUpdatesAtTheSameTimeGiveNoRate() {
        rateMeter.update(listOf(streamStatus("depth", produced = 100)), nowMillis = 1_000)
        assertEquals(emptyMap(), rateMeter.update(listOf(streamStatus("depth", produced = 101)), nowMillis = 1_000))
    }
}
