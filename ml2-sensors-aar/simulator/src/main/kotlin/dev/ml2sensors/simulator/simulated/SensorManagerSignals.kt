package dev.ml2sensors.simulator.simulated

import dev.ml2sensors.simulator.signal.Signal
import dev.ml2sensors.source.BatterySample
import dev.ml2sensors.source.ChargeStatus
import dev.ml2sensors.source.ImuUnit
import dev.ml2sensors.source.ScalarSample
import dev.ml2sensors.source.VectorSample
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable

/** Returns the signals that Android's SensorManager would deliver on the simulated headset. */
internal fun sensorManagerSignals(): Map<StreamSpec, Signal> = buildMap {
    for (unit in ImuUnit.entries) {
        put(unit.accelerometer, vectors(unit, IMU_HZ, ACCELERATION))
        put(unit.gyroscope, vectors(unit, IMU_HZ, ANGULAR_VELOCITY))
    }
    put(StreamTable.magnetometerLeft, vectors(ImuUnit.LEFT, MAGNETOMETER_HZ, MAGNETIC_FIELD))
    put(StreamTable.magnetometerRight, vectors(ImuUnit.RIGHT, MAGNETOMETER_HZ, MAGNETIC_FIELD))
    put(StreamTable.pressureHeadset, pressure(ImuUnit.LEFT))
    put(StreamTable.pressureComputePack, pressure(ImuUnit.COMPUTE_PACK))
    put(StreamTable.lightSensor, Signal(LIGHT_HZ) { ScalarSample(it.nanos, SimulatedSdk.light(it.nanos).toDouble()) })
}

/** Returns the signal of Android's BatteryManager: the battery discharges from 90 % to 5 %, then starts again. */
internal fun batteryManagerSignals(): Map<StreamSpec, Signal> = mapOf(
    StreamTable.battery to Signal(BATTERY_HZ) { capture ->
        val charge = (0.9 - 0.85 * (capture.seconds / CHARGE_SECONDS % 1)).toFloat()
        BatterySample(capture.nanos, voltage = 7.0f + 1.4f * charge, current = -1.6f, charge, ChargeStatus.DISCHARGING)
    },
)

private fun vectors(unit: ImuUnit, rateHz: Int, first: Int) = Signal(rateHz) { capture ->
    val values = FloatArray(NUMBERS)
    SimulatedSdk.inertial(unit.ordinal, capture.nanos, values)
    val (x, y, z) = List(3) { values[first + it].toDouble() }
    VectorSample(capture.nanos, x, y, z)
}

private fun pressure(unit: ImuUnit) = Signal(PRESSURE_HZ) {
    ScalarSample(it.nanos, SimulatedSdk.pressure(unit.ordinal, it.nanos).toDouble())
}

/** The index of each quantity in the output of [SimulatedSdk.inertial]. Units are in the order of ml2sim_unit. */
private const val ACCELERATION = 0
private const val ANGULAR_VELOCITY = 3
private const val MAGNETIC_FIELD = 6
private const val NUMBERS = 9

/** A headset delivers about 210 Hz. */
private const val IMU_HZ = 200
private const val MAGNETOMETER_HZ = 50
private const val PRESSURE_HZ = 10
private const val LIGHT_HZ = 5
private const val BATTERY_HZ = 1
private const val CHARGE_SECONDS = 3.5 * 3600
