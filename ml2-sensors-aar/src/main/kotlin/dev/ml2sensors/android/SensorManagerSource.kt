package dev.ml2sensors.android

import android.content.Context
import android.hardware.Sensor
import android.hardware.SensorEvent
import android.hardware.SensorEventListener
import android.hardware.SensorManager
import android.os.Handler
import android.os.HandlerThread
import android.os.Process
import dev.ml2sensors.capture.LocalFrames
import dev.ml2sensors.capture.SampleQueue
import dev.ml2sensors.source.Answer
import dev.ml2sensors.source.ClockDomain
import dev.ml2sensors.source.DropReason
import dev.ml2sensors.source.LostSamples
import dev.ml2sensors.source.PlatformCalls
import dev.ml2sensors.source.Sample
import dev.ml2sensors.source.ScalarSample
import dev.ml2sensors.source.SensorSource
import dev.ml2sensors.source.SourceException
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.source.VectorSample
import dev.ml2sensors.table.StreamSpec
import kotlinx.coroutines.flow.Flow
import kotlinx.coroutines.flow.MutableStateFlow
import kotlinx.coroutines.flow.update

/**
 * Reads inertial units, magnetometers, barometers and the light sensor through Android's SensorManager: at the fastest
 * rate the device allows, unbatched, stamped by the hardware, in the sensor's own axes. A magnetometer is the
 * calibrated one if the device lists it, else the uncalibrated one, whose field includes the bias of the device.
 *
 * Readings arrive on a thread of this source. Those that a slow collector misses are counted as lost.
 *
 * @param foundBases receives the clock behind the timestamps of each stream that runs.
 */
internal class SensorManagerSource(
    private val context: Context,
    private val clocks: SystemClocks = SystemClocks(),
    private val foundBases: MutableStateFlow<Map<StreamSpec, ClockDomain>> = MutableStateFlow(emptyMap()),
    calls: PlatformCalls = PlatformCalls(),
) : SensorSource {
    private val thread = HandlerThread("ml2s-sensors", Process.THREAD_PRIORITY_DISPLAY).apply { start() }
    private val handler = Handler(thread.looper)
    private val access = SensorAccess(calls)

    /** Asked for at each use, since Android may not answer. It keeps its managers itself. */
    private val sensorManager: SensorManager get() = context.getSystemService(SensorManager::class.java)

    override val backend: String get() = "sensor_manager"

    override val streams: Set<StreamSpec> = SensorRow.ALL.mapTo(LinkedHashSet()) { it.stream }

    override fun negotiate(stream: StreamSpec, requested: StreamValues): Answer =
        if (find(stream) != null) Answer.Applied(requested) else Answer.Refused(absence(stream))

    override fun samples(stream: StreamSpec, values: StreamValues): Flow<Sample> =
        access.callbackSamples("$stream") { queue ->
            val (row, sensor) = find(stream) ?: throw SourceException(absence(stream))
            val isOnChange = row.isOnChange || sensor.reportingMode != Sensor.REPORTING_MODE_CONTINUOUS
            val timestamps =
                TimestampConverter(clocks, isOnChange) { base -> foundBases.update { it + (stream to base) } }
            val listener = Listener(row, timestamps, queue)
            val manager = sensorManager
            // Android delivers at the sensor's minDelay if it is asked for the fastest rate
            if (!manager.registerListener(listener, sensor, FASTEST, UNBATCHED_MICROS, handler)) {
                throw SourceException("Android does not start the sensor ${sensor.name}")
            }
            AutoCloseable { manager.unregisterListener(listener) }
        }

    override fun pause(): Unit = access.pause()

    override fun resume(): Unit = access.resume()

    /** Ends all flows. */
    override fun close() {
        access.close()
        thread.quitSafely()
    }

    private fun find(stream: StreamSpec): Pair<SensorRow, Sensor>? {
        // A sensor that can also wake the device up is listed once more, as another
        val listed = sensorManager.getSensorList(Sensor.TYPE_ALL).filterNot { it.isWakeUpSensor }
        return SensorRow.ALL.filter { it.stream == stream }.firstNotNullOfOrNull { row ->
            listed.singleOrNull(row::matches)?.let { row to it }
        }
    }

    private fun absence(stream: StreamSpec): String {
        val name = SensorRow.ALL.first { it.stream == stream }.name
        val listed = sensorManager.getSensorList(Sensor.TYPE_ALL).map { it.name }.ifEmpty { listOf("nothing") }
        return "this headset lists no single $name sensor; it lists: ${listed.joinToString()}"
    }

    private inner class Listener(
        private val row: SensorRow,
        private val timestamps: TimestampConverter,
        private val queue: SampleQueue,
    ) : SensorEventListener {
        override fun onSensorChanged(event: SensorEvent) {
            try {
                val captureNanos = timestamps.captureNanos(event.timestamp)
                val sample = captureNanos?.let { row.sample(it, event.values) }
                when {
                    sample == null -> lose(DropReason.SOURCE_LATE)
                    sample.isFinite -> deliver(sample)
                    else -> lose(DropReason.UNUSABLE)
                }
            } catch (e: SourceException) {
                queue.countLost(1, DropReason.SOURCE_LATE)
                queue.close(e)
            }
        }

        override fun onAccuracyChanged(sensor: Sensor, accuracy: Int) = Unit

        private fun lose(reason: DropReason) = queue.offer(LostSamples(clocks.boot.nowNanos(), 1, reason))

        private fun deliver(sample: Sample) {
            if (sample is VectorSample) LocalFrames.copy(row.stream, sample)
            queue.offer(sample)
        }

        private val Sample.isFinite: Boolean
            get() = when (this) {
                is VectorSample -> x.isFinite() && y.isFinite() && z.isFinite()
                is ScalarSample -> value.isFinite()
                else -> true
            }
    }

    private companion object {
        const val FASTEST = SensorManager.SENSOR_DELAY_FASTEST
        const val UNBATCHED_MICROS = 0
    }
}
