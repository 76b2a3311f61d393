package dev.ml2sensors.android

import android.hardware.Sensor
import dev.ml2sensors.source.Sample
import dev.ml2sensors.source.ScalarSample
import dev.ml2sensors.source.VectorSample
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable

/**
 * Maps one of Android's sensors to a stream, and its values to SI units.
 *
 * @property type one of the constants of [Sensor].
 * @property name part of the sensor's name: several sensors have the same type, in no defined order.
 */
internal class SensorRow(
    val stream: StreamSpec,
    val type: Int,
    val name: String,
    val sample: (captureNanos: Long, values: FloatArray) -> Sample,
) {
    /**
     * True if Android reports this type only when its value changes. It reports the latest value, however old, when the
     * sensor is registered, and then nothing while the value is steady.
     */
    val isOnChange: Boolean get() = type == Sensor.TYPE_LIGHT

    fun matches(sensor: Sensor): Boolean = sensor.type == type && name in sensor.name

    companion object {
        private const val PASCAL_PER_HECTOPASCAL = 100.0
        private const val TESLA_PER_MICROTESLA = 1e-6

        /**
         * The sensors of each stream, the preferred one first. Source of the names: the vendor's documentation of
         * generic sensors. The uncalibrated magnetometer's field includes the bias that Android estimates.
         */
        val ALL: List<SensorRow> = listOf(
            SensorRow(StreamTable.accelLeft, Sensor.TYPE_ACCELEROMETER, "Headset Left Accelerometer", vector()),
            SensorRow(StreamTable.accelRight, Sensor.TYPE_ACCELEROMETER, "Headset Right Accelerometer", vector()),
            SensorRow(StreamTable.accelComputePack, Sensor.TYPE_ACCELEROMETER, "Compute Pack Accelerometer", vector()),
            SensorRow(StreamTable.gyroLeft, Sensor.TYPE_GYROSCOPE, "Headset Left Gyroscope", vector()),
            SensorRow(StreamTable.gyroRight, Sensor.TYPE_GYROSCOPE, "Headset Right Gyroscope", vector()),
            SensorRow(StreamTable.gyroComputePack, Sensor.TYPE_GYROSCOPE, "Compute Pack Gyroscope", vector()),
            SensorRow(StreamTable.lightSensor, Sensor.TYPE_LIGHT, "Ambient Light", scalar()),
            pressure(StreamTable.pressureHeadset, "Headset Pressure"),
            pressure(StreamTable.pressureComputePack, "Compute Pack Pressure"),
            calibrated(StreamTable.magnetometerLeft, "Headset Left Calibrated Magnetometer"),
            uncalibrated(StreamTable.magnetometerLeft, "Headset Left Uncalibrated Magnetometer"),
            calibrated(StreamTable.magnetometerRight, "Headset Right Calibrated Magnetometer"),
            uncalibrated(StreamTable.magnetometerRight, "Headset Right Uncalibrated Magnetometer"),
        )

        private fun pressure(stream: StreamSpec, name: String) =
            SensorRow(stream, Sensor.TYPE_PRESSURE, name, scalar(PASCAL_PER_HECTOPASCAL))

        private fun calibrated(stream: StreamSpec, name: String) =
            SensorRow(stream, Sensor.TYPE_MAGNETIC_FIELD, name, vector(TESLA_PER_MICROTESLA))

        private fun uncalibrated(stream: StreamSpec, name: String) =
            SensorRow(stream, Sensor.TYPE_MAGNETIC_FIELD_UNCALIBRATED, name, vector(TESLA_PER_MICROTESLA))

        private fun scalar(unit: Double = 1.0) = { captureNanos: Long, values: FloatArray ->
            ScalarSample(captureNanos, values[0] * unit)
        }

        private fun vector(unit: Double = 1.0) = { captureNanos: Long, values: FloatArray ->
            VectorSample(captureNanos, values[0] * unit, values[1] * unit, values[2] * unit)
        }
    }
}
