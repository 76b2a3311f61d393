package dev.ml2sensors.android

import android.hardware.Sensor
import android.hardware.SensorManager
import app.cash.turbine.Event
import dev.ml2sensors.source.Answer
import dev.ml2sensors.source.ClockDomain
import dev.ml2sensors.source.DropReason
import dev.ml2sensors.source.LostSamples
import dev.ml2sensors.source.NoAnswerException
import dev.ml2sensors.source.Sample
import dev.ml2sensors.source.ScalarSample
import dev.ml2sensors.source.SourceException
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.source.VectorSample
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable
import dev.ml2sensors.test
import kotlinx.coroutines.CompletableDeferred
import kotlinx.coroutines.flow.MutableStateFlow
import kotlinx.coroutines.flow.take
import kotlinx.coroutines.flow.toList
import kotlinx.coroutines.launch
import kotlinx.coroutines.runBlocking
import kotlinx.coroutines.yield
import org.junit.After
import org.junit.Test
import org.junit.runner.RunWith
import org.robolectric.RobolectricTestRunner
import org.robolectric.RuntimeEnvironment
import org.robolectric.annotation.Config
import kotlin.test.assertEquals
import kotlin.test.assertIs
import kotlin.test.assertNotEquals
import kotlin.test.assertNull
import kotlin.test.assertTrue

/** On Android 10's own SensorManager, with a hub of sensors below it. */
@RunWith(RobolectricTestRunner::class)
@Config(
    sdk = [29],
    manifest = Config.NONE,
    shadows = [
        SensorHub.RealSensorManager::class, SensorHub.RealSystemSensorManager::class, SensorHub.NativeQueue::class,
    ],
)
class SensorManagerSourceTest {
    private val sensorManager = RuntimeEnvironment.getApplication().getSystemService(SensorManager::class.java)
    private val hub = SensorHub(sensorManager)
    private val device = SettableClocks(monotonicNanos = 500 * SECOND, suspendedNanos = 7_000 * SECOND)
    private val bases = MutableStateFlow<Map<StreamSpec, ClockDomain>>(emptyMap())
    private val source = SensorManagerSource(RuntimeEnvironment.getApplication(), device.clocks, bases)

    @After
    fun close() {
        source.close()
        SensorHub.NativeQueue.reset()
    }

    @Test
    fun everyStreamIsFoundByNameHoweverTheyAreListed() = runBlocking {
        val rows = SensorRow.ALL.filterNot { it.type == Sensor.TYPE_MAGNETIC_FIELD_UNCALIBRATED }
        val sensors = rows.reversed().associate { it.stream to hub.add(it.type, "${it.name} Sensor") }
        assertEquals(source.streams, sensors.keys)
        for ((stream, sensor) in sensors) {
            assertEquals(Answer.Applied(StreamValues()), source.negotiate(stream, StreamValues()), "$stream")
            source.samples(stream, StreamValues()).test {
                assertEquals(setOf(sensor), hub.enabled.keys, "$stream")
                cancel()
            }
        }
    }

    @Test
    fun aSensorRunsAsFastAsItCanAndUnbatchedOnAThreadOfTheSource() = runBlocking {
        val sensor = hub.add(Sensor.TYPE_GYROSCOPE, "Headset Left Gyroscope Sensor")
        source.samples(StreamTable.gyroLeft, StreamValues()).test {
            assertEquals(SensorManager.SENSOR_DELAY_FASTEST to 0, hub.enabled[sensor])
            assertEquals("ml2s-sensors", hub.threadOf(sensor).name)
            cancel()
        }
        assertEquals(emptySet(), hub.enabled.keys, "unregistered with the end of the collector")
    }

    @Test
    fun readingsComeInOrderWithTheTimeOfTheHardwareAndMemoryOfTheirOwn() = runBlocking {
        val sensor = hub.add(Sensor.TYPE_ACCELEROMETER, "Headset Right Accelerometer Sensor")
        val timestamps = List(3) { device.bootNanos - 5_000_000 + it * 1_000_000L }
        source.samples(StreamTable.accelRight, StreamValues()).test {
            timestamps.forEachIndexed { i, timestamp -> hub.measure(sensor, timestamp, i + 0.25f, -2f, 9.75f) }
            val readings = List(3) { assertIs<VectorSample>(awaitItem()) }
            assertEquals(timestamps, readings.map { it.captureNanos })
            assertEquals(listOf(0.25, 1.25, 2.25), readings.map { it.x })
            assertEquals(listOf(-2.0, 9.75), readings.last().let { listOf(it.y, it.z) })
            cancel()
        }
        assertEquals(mapOf(StreamTable.accelRight to ClockDomain.BOOTTIME), bases.value)
    }

    @Test
    fun timestampsOfTheMonotonicClockAreConvertedAndSaid() = runBlocking {
        val sensor = hub.add(Sensor.TYPE_GYROSCOPE, "Compute Pack Gyroscope Sensor")
        source.samples(StreamTable.gyroComputePack, StreamValues()).test {
            hub.measure(sensor, device.monotonicNanos - 2_000_000, 1f, 2f, 3f)
            assertEquals(device.bootNanos - 2_000_000, awaitItem().captureNanos)
            cancel()
        }
        assertEquals(ClockDomain.MONOTONIC, bases.value[StreamTable.gyroComputePack])
    }

    @Test
    fun aPausedSourceReleasesItsSensorsAndTheFlowGoesOnAfterwards() = runBlocking {
        val sensor = hub.add(Sensor.TYPE_GYROSCOPE, "Headset Left Gyroscope Sensor")
        source.samples(StreamTable.gyroLeft, StreamValues()).test {
            source.pause()
            source.pause()
            while (hub.enabled.isNotEmpty()) yield()
            source.resume()
            while (hub.enabled.isEmpty()) yield()
            hub.measure(sensor, device.bootNanos - 2_000_000, 1f, 2f, 3f)
            assertEquals(device.bootNanos - 2_000_000, awaitItem().captureNanos)
            source.pause()
            source.close()
            source.resume()
            awaitComplete()
        }
        assertEquals(emptySet(), hub.enabled.keys)
    }

    @Test
    fun readingsAreInSiUnits() = runBlocking {
        val pressure = hub.add(Sensor.TYPE_PRESSURE, "Headset Pressure Sensor")
        assertEquals(101_325.0, scalar(StreamTable.pressureHeadset, pressure, 1013.25f), 0.01)
        val light = hub.add(Sensor.TYPE_LIGHT, "Ambient Light Sensor")
        assertEquals(300.5, scalar(StreamTable.lightSensor, light, 300.5f))
        val field = hub.add(Sensor.TYPE_MAGNETIC_FIELD, "Headset Left Calibrated Magnetometer Sensor")
        val reading = assertIs<VectorSample>(first(StreamTable.magnetometerLeft, field, 20f, -40f, 0.5f))
        assertEquals(20e-6, reading.x, 1e-15)
        assertEquals(-40e-6, reading.y, 1e-15)
        assertEquals(0.5e-6, reading.z, 1e-15)
    }

    @Test
    fun aMagnetometerIsTheCalibratedOneWhereThereAreBoth() = runBlocking {
        val raw = hub.add(Sensor.TYPE_MAGNETIC_FIELD_UNCALIBRATED, "Headset Left Uncalibrated Magnetometer Sensor")
        assertEquals(
            5e-6,
            assertIs<VectorSample>(first(StreamTable.magnetometerLeft, raw, 5f, 0f, 0f, 1f, 1f, 1f)).x,
            1e-15,
        )
        val calibrated = hub.add(Sensor.TYPE_MAGNETIC_FIELD, "Headset Left Calibrated Magnetometer Sensor")
        source.samples(StreamTable.magnetometerLeft, StreamValues()).test {
            assertEquals(setOf(calibrated), hub.enabled.keys)
            cancel()
        }
    }

    @Test
    fun aSensorThatIsNotListedIsRefusedWithThoseThatAre() {
        assertEquals(
            Answer.Refused("this headset lists no single Headset Left Gyroscope sensor; it lists: nothing"),
            source.negotiate(StreamTable.gyroLeft, StreamValues()),
        )
        hub.add(Sensor.TYPE_GYROSCOPE, "Headset Right Gyroscope Sensor")
        hub.add(Sensor.TYPE_GYROSCOPE, "Controller Gyroscope Sensor")
        val expected = "this headset lists no single Headset Left Gyroscope sensor; " +
            "it lists: Headset Right Gyroscope Sensor, Controller Gyroscope Sensor"
        assertEquals(Answer.Refused(expected), source.negotiate(StreamTable.gyroLeft, StreamValues()))
        runBlocking {
            source.samples(StreamTable.gyroLeft, StreamValues()).test {
                assertEquals(expected, assertIs<SourceException>(awaitError()).message)
            }
        }
    }

    @Test
    fun theTwinOfASensorThatWakesTheDeviceUpIsNotTaken() = runBlocking {
        hub.add(Sensor.TYPE_PRESSURE, "Compute Pack Pressure Sensor", wakesUp = true)
        val sensor = hub.add(Sensor.TYPE_PRESSURE, "Compute Pack Pressure Sensor")
        source.samples(StreamTable.pressureComputePack, StreamValues()).test {
            assertEquals(setOf(sensor), hub.enabled.keys)
            cancel()
        }
    }

    @Test
    fun theLastKnownLightIsDeliveredWithItsOwnStampAndTheNextStampIsRight() = runBlocking {
        val light = hub.add(Sensor.TYPE_LIGHT, "Ambient Light Sensor")
        assertNull(StreamTable.lightSensor.longestPauseSeconds, "a steady light is reported once")
        for (ageSeconds in listOf(10, 61, 7_000, 7_100)) {
            source.samples(StreamTable.lightSensor, StreamValues()).test {
                val old = device.bootNanos - ageSeconds * SECOND - 1
                hub.measure(light, old, 300f)
                assertEquals(old, assertIs<ScalarSample>(awaitItem()).captureNanos, "$ageSeconds s old")
                hub.measure(light, device.bootNanos - 1, 301f)
                assertEquals(device.bootNanos - 1, assertIs<ScalarSample>(awaitItem()).captureNanos)
                cancel()
            }
        }
    }

    @Test
    fun whateverTheDeviceReportsOnChangeMayBeOldWhenItIsRegistered() = runBlocking {
        val pressure = hub.add(Sensor.TYPE_PRESSURE, "Headset Pressure Sensor", isOnChange = true)
        source.samples(StreamTable.pressureHeadset, StreamValues()).test {
            val old = device.bootNanos - 7_000 * SECOND - 1
            hub.measure(pressure, old, 1_000f)
            assertEquals(old, assertIs<ScalarSample>(awaitItem()).captureNanos)
            hub.measure(pressure, device.bootNanos - 1, 1_001f)
            assertEquals(device.bootNanos - 1, assertIs<ScalarSample>(awaitItem()).captureNanos)
            cancel()
        }
    }

    @Test
    fun readingsThatAreNoNumbersAreLostAndCounted() = runBlocking {
        val gyro = hub.add(Sensor.TYPE_GYROSCOPE, "Headset Left Gyroscope Sensor")
        val light = hub.add(Sensor.TYPE_LIGHT, "Ambient Light Sensor")
        for ((stream, sensor) in listOf(StreamTable.gyroLeft to gyro, StreamTable.lightSensor to light)) {
            source.samples(stream, StreamValues()).test {
                val axes = if (stream == StreamTable.gyroLeft) 0..2 else 0..0
                for (odd in listOf(Float.NaN, Float.POSITIVE_INFINITY, Float.NEGATIVE_INFINITY)) {
                    for (axis in axes) {
                        hub.measure(sensor, device.bootNanos, *FloatArray(3) { if (it == axis) odd else 1f })
                        val lost = assertIs<LostSamples>(awaitItem(), "$stream: $odd")
                        assertEquals(1 to DropReason.UNUSABLE, lost.count to lost.reason)
                    }
                }
                hub.measure(sensor, device.bootNanos, 1f, 2f, 3f)
                assertTrue(awaitItem() !is LostSamples)
                cancel()
            }
        }
    }

    @Test
    fun aRegistrationThatDoesNotReturnFailsItsFlowAndIsUndoneWhenItDoes() = runBlocking {
        val sensor = hub.add(Sensor.TYPE_LIGHT, "Ambient Light Sensor")
        val answer = NeverReturns.hold("SensorManager.registerListener")
        repeat(2) {
            source.samples(StreamTable.lightSensor, StreamValues()).test {
                val failure = assertIs<NoAnswerException>(awaitError())
                val expected = "Android's registration of light_sensor: no answer within"
                assertTrue(failure.message.orEmpty().startsWith(expected), "$failure")
            }
        }
        answer()
        while (hub.queueCount > 0) yield()
        source.samples(StreamTable.lightSensor, StreamValues()).test {
            hub.measure(sensor, device.bootNanos, 1f)
            assertIs<ScalarSample>(awaitItem())
            cancel()
        }
    }

    @Test
    fun aSensorThatDoesNotStartFailsItsFlow() = runBlocking {
        hub.add(Sensor.TYPE_LIGHT, "Ambient Light Sensor")
        SensorHub.refuses = true
        source.samples(StreamTable.lightSensor, StreamValues()).test {
            assertEquals("Android does not start the sensor Ambient Light Sensor", awaitError().message)
        }
    }

    @Test
    fun whateverARegistrationThrowsFailsItsFlowWithAType() = runBlocking {
        hub.add(Sensor.TYPE_LIGHT, "Ambient Light Sensor")
        for (thrown in listOf(IllegalStateException("too many"), NullPointerException(null))) {
            SensorHub.failure = thrown
            source.samples(StreamTable.lightSensor, StreamValues()).test {
                val said = thrown.message ?: "NullPointerException"
                val failure = assertIs<SourceException>(awaitError())
                assertEquals("Android's registration of light_sensor failed: $said", failure.message)
            }
        }
    }

    @Test
    fun aSlowCollectorLosesReadingsThatAreCountedAndNoOthers() = runBlocking {
        val sensor = hub.add(Sensor.TYPE_GYROSCOPE, "Headset Left Gyroscope Sensor")
        val started = CompletableDeferred<Unit>()
        val received = mutableListOf<Sample>()
        val goOn = CompletableDeferred<Unit>()
        val collector = launch {
            source.samples(StreamTable.gyroLeft, StreamValues()).collect {
                received += it
                started.complete(Unit)
                goOn.await()
            }
        }
        while (hub.enabled.isEmpty()) yield()
        hub.measure(sensor, device.bootNanos, 0f, 0f, 0f)
        started.await()
        repeat(999) { hub.measure(sensor, device.bootNanos, 0f, 0f, 0f) }
        goOn.complete(Unit)
        repeat(1_000) { yield() }
        hub.measure(sensor, device.bootNanos, 1f, 0f, 0f)
        while ((received.last() as? VectorSample)?.x != 1.0) yield()
        collector.cancel()
        val lost = received.filterIsInstance<LostSamples>().single()
        assertEquals(DropReason.SOURCE_LATE, lost.reason)
        assertEquals(1_001, lost.count + received.count { it is VectorSample })
        assertNotEquals(0, lost.count)
    }

    @Test
    fun theReadingThatEndsARunIsCountedAsLostToo() = runBlocking {
        val sensor = hub.add(Sensor.TYPE_LIGHT, "Ambient Light Sensor")
        var lost = 0
        source.samples(StreamTable.lightSensor, StreamValues()).test {
            repeat(100) { hub.measure(sensor, timestamp = 0, 1f) }
            while (true) {
                val event = awaitEvent() as? Event.Item ?: break
                lost += assertIs<LostSamples>(event.value).count
            }
        }
        assertEquals(100, lost)
    }

    @Test
    fun closingTheSourceEndsItsFlows() = runBlocking {
        hub.add(Sensor.TYPE_LIGHT, "Ambient Light Sensor")
        source.samples(StreamTable.lightSensor, StreamValues()).test {
            source.close()
            awaitComplete()
        }
        assertEquals(emptySet(), hub.enabled.keys)
        assertEquals(emptyList(), source.samples(StreamTable.lightSensor, StreamValues()).toList())
    }

    private suspend fun scalar(stream: StreamSpec, sensor: Sensor, vararg values: Float) =
        assertIs<ScalarSample>(first(stream, sensor, *values)).value

    private suspend fun first(stream: StreamSpec, sensor: Sensor, vararg values: Float): Sample {
        lateinit var reading: Sample
        source.samples(stream, StreamValues()).take(1).test {
            hub.measure(sensor, device.bootNanos, *values)
            reading = awaitItem()
            awaitComplete()
        }
        return reading
    }

    private companion object {
        const val SECOND = 1_000_000_000L
    }
}
