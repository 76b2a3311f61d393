package dev.ml2sensors.simulator.testsignal

import dev.ml2sensors.message.Transform
import dev.ml2sensors.message.times
import dev.ml2sensors.simulator.signal.Signal
import dev.ml2sensors.source.BatterySample
import dev.ml2sensors.source.ChargeStatus
import dev.ml2sensors.source.ScalarSample
import kotlin.math.PI
import kotlin.math.pow
import kotlin.math.sin

/** Returns the signals of slow sensors. */
internal fun environmentSignals(trajectory: Trajectory): Map<String, Signal> = mapOf(
    "light_sensor" to scalars(5) { 300 + 120 * sin(2 * PI * 0.1 * it) + 30 * sin(2 * PI * 0.77 * it) },
    "pressure_headset" to scalars(10) { pressure(trajectory.at(it).pose) },
    "pressure_compute_pack" to
        scalars(10) { pressure(trajectory.at(it).pose * SENSOR_EXTRINSICS.getValue("imu_compute_pack")) },
    "battery" to battery(),
)

/** Discharges from 90 % to 5 %, then starts again. */
internal fun battery() = Signal(1) { capture ->
    val charge = (0.9 - 0.85 * (capture.seconds / CHARGE_SECONDS % 1)).toFloat()
    BatterySample(capture.nanos, voltage = 7.0f + 1.4f * charge, current = -1.6f, charge, ChargeStatus.DISCHARGING)
}

private const val CHARGE_SECONDS = 3.5 * 3600

private fun scalars(rateHz: Int, read: (seconds: Double) -> Double) =
    Signal(rateHz) { ScalarSample(it.nanos, read(it.seconds)) }

/** Returns the pressure in pascal at the height of [place], by the barometric formula of ISO 2533. */
private fun pressure(place: Transform) = 101_325 * (1 - 2.25577e-5 * place.translation.z).pow(5.25588)
