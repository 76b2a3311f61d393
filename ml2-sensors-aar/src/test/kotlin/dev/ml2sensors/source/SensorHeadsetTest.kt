package dev.ml2sensors.source

import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable
import kotlinx.coroutines.flow.Flow
import kotlinx.coroutines.flow.flowOf
import kotlinx.coroutines.flow.single
import kotlinx.coroutines.test.runTest
import org.junit.jupiter.api.Test
import kotlin.test.assertEquals
import kotlin.test.assertFailsWith
import kotlin.test.assertFalse
import kotlin.test.assertTrue

class SensorHeadsetTest {
    private val sdk = FakeSource("sdk", setOf(StreamTable.worldLeft), captureNanos = 1)
    private val openxr = FakeSource("openxr", setOf(StreamTable.worldLeft, StreamTable.gaze), captureNanos = 2)
    private val headset =
        SensorHeadset(Headset.Identity("id", "name"), { 0L }, listOf(openxr, sdk)) { mapOf("CAMERA" to false) }

    @Test
    fun theFirstBackendOfTheTableServesUnlessAnotherIsNamed() = runTest {
        assertEquals(1, headset.samples(StreamTable.worldLeft, StreamValues()).single().captureNanos)
        val wanted = StreamValues(backend = "openxr")
        assertEquals(Answer.Adjusted(wanted, "by openxr"), headset.negotiate(StreamTable.worldLeft, wanted))
        assertEquals(2, headset.samples(StreamTable.worldLeft, wanted).single().captureNanos)
    }

    @Test
    fun aStreamOfNoSourceIsRefused() {
        val answer = headset.negotiate(StreamTable.battery, StreamValues())
        assertEquals(Answer.Refused("this headset has no battery"), answer)
        assertFailsWith<IllegalArgumentException> { headset.samples(StreamTable.battery, StreamValues()) }
    }

    @Test
    fun aBackendThatIsNotThereIsRefusedWithThoseThatAre() {
        val answer = headset.negotiate(StreamTable.gaze, StreamValues(backend = "sdk"))
        assertEquals(Answer.Refused("this headset has no backend sdk for gaze, only openxr"), answer)
    }

    @Test
    fun closingItClosesItsSources() {
        headset.close()
        assertTrue(sdk.isClosed && openxr.isClosed)
    }

    @Test
    fun aPauseIsOfAllSourcesAndHoldsTheirStreamsUntilItEnds() {
        headset.pause()
        assertTrue(sdk.isPaused && openxr.isPaused)
        assertEquals(setOf("world_left", "gaze"), headset.holds.keys)
        headset.resume()
        assertFalse(sdk.isPaused || openxr.isPaused)
        assertEquals(emptyMap(), headset.holds)
    }

    @Test
    fun permissionsAreReadWhenAskedFor() {
        assertEquals(mapOf("CAMERA" to false), headset.permissions)
    }
}

private class FakeSource(
    override val backend: String,
    override val streams: Set<StreamSpec>,
    private val captureNanos: Long,
) : SensorSource {
    var isClosed = false
        private set
    var isPaused = false
        private set

    override fun negotiate(stream: StreamSpec, requested: StreamValues): Answer =
        Answer.Adjusted(requested, "by $backend")

    override fun samples(stream: StreamSpec, values: StreamValues): Flow<Sample> =
        flowOf(ScalarSample(captureNanos, 0.0))

    override fun pause() {
        isPaused = true
    }

    override fun resume() {
        isPaused = false
    }

    override fun close() {
        isClosed = true
    }
}
