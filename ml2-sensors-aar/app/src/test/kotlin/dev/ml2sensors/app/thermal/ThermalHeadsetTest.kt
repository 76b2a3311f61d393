package dev.ml2sensors.app.thermal

import dev.ml2sensors.source.Answer
import dev.ml2sensors.source.DeviceClock
import dev.ml2sensors.source.Headset
import dev.ml2sensors.source.Sample
import dev.ml2sensors.source.ScalarSample
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.source.Thermal
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable
import kotlinx.coroutines.ExperimentalCoroutinesApi
import kotlinx.coroutines.delay
import kotlinx.coroutines.flow.Flow
import kotlinx.coroutines.flow.flow
import kotlinx.coroutines.launch
import kotlinx.coroutines.test.TestScope
import kotlinx.coroutines.test.advanceTimeBy
import kotlinx.coroutines.test.runCurrent
import kotlinx.coroutines.test.runTest
import org.junit.jupiter.api.Test
import kotlin.test.assertEquals
import kotlin.test.assertFalse
import kotlin.test.assertTrue

@OptIn(ExperimentalCoroutinesApi::class)
class ThermalHeadsetTest {
    private val device = FakeHeadset()
    private var isEnabled = true
    private val headset = ThermalHeadset(device) { isEnabled }

    @Test
    fun rgbIsPausedFirstAndTheOtherCamerasLater() {
        assertEquals(Thermal.SEVERE, ThermalPolicy.limit(StreamTable.color))
        assertEquals(Thermal.SEVERE, ThermalPolicy.limit(StreamTable.mixedReality))
        assertEquals(Thermal.CRITICAL, ThermalPolicy.limit(StreamTable.worldLeft))
        assertEquals(Thermal.CRITICAL, ThermalPolicy.limit(StreamTable.depth))
        for (stream in listOf(StreamTable.imuLeft, StreamTable.headPose, StreamTable.battery)) {
            assertEquals(null, ThermalPolicy.limit(stream))
        }
    }

    @Test
    fun aPausedCameraIsClosedAndResumesWhenTheHeadsetIsMuchCooler() = collecting(StreamTable.color) { received ->
        advanceTimeBy(5_500)
        assertEquals(5, received.size)
        device.thermal = Thermal.SEVERE
        advanceTimeBy(10_000)
        assertFalse(device.isOpen)
        assertEquals(setOf("color"), headset.paused)
        device.thermal = Thermal.MODERATE
        advanceTimeBy(10_000)
        assertFalse(device.isOpen, "not yet")
        assertEquals(5, received.size)
        device.thermal = Thermal.LIGHT
        advanceTimeBy(10_000)
        assertTrue(device.isOpen)
        assertTrue(received.size > 10)
        assertEquals(emptySet(), headset.paused)
    }

    @Test
    fun nothingIsPausedWhileDisabled() = collecting(StreamTable.color) { received ->
        isEnabled = false
        device.thermal = Thermal.SHUTDOWN
        advanceTimeBy(5_500)
        assertEquals(5, received.size)
    }

    @Test
    fun disablingResumesTheCamera() = collecting(StreamTable.color) { received ->
        device.thermal = Thermal.SEVERE
        advanceTimeBy(5_500)
        assertEquals(0, received.size)
        isEnabled = false
        advanceTimeBy(5_500)
        assertTrue(received.isNotEmpty())
    }

    @Test
    fun smallStreamsAreNeverPaused() = collecting(StreamTable.imuLeft) { received ->
        device.thermal = Thermal.EMERGENCY
        advanceTimeBy(5_500)
        assertEquals(5, received.size)
    }

    @Test
    fun theEndOfAStreamIsPassedOn() = runTest {
        device.count = 3
        val received = ArrayList<Sample>()
        headset.samples(StreamTable.color, StreamValues()).collect(received::add)
        assertEquals(3, received.size)
    }

    private fun collecting(stream: StreamSpec, test: TestScope.(List<Sample>) -> Unit) = runTest {
        val received = ArrayList<Sample>()
        val collector = launch { headset.samples(stream, StreamValues()).collect(received::add) }
        runCurrent()
        test(received)
        collector.cancel()
    }

    /** Delivers a sample per second. */
    private class FakeHeadset : Headset {
        override var thermal: Thermal? = Thermal.NONE
        var isOpen = false
        var count = Int.MAX_VALUE
        override val identity = Headset.Identity("id", "name")
        override val clock = DeviceClock { 0 }
        override val timeline = Headset.Timeline.LIVE

        override fun negotiate(stream: StreamSpec, requested: StreamValues) = Answer.Applied(requested)

        override fun samples(stream: StreamSpec, values: StreamValues): Flow<Sample> = flow {
            isOpen = true
            try {
                repeat(count) {
                    delay(1_000)
                    emit(ScalarSample(0, 0.0))
                }
            } finally {
                isOpen = false
            }
        }

        override fun close() = Unit
    }
}
