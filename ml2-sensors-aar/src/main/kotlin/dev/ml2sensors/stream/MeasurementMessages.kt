package dev.ml2sensors.stream

import dev.ml2sensors.message.BatteryState
import dev.ml2sensors.message.Header
import dev.ml2sensors.message.Joy
import dev.ml2sensors.source.BatterySample
import dev.ml2sensors.source.InputSample
import kotlinx.serialization.Serializable

/**
 * FluidPressure, Illuminance, RelativeHumidity or Temperature of sensor_msgs (Jazzy), as the stream table types the
 * topic: they differ in the name and the unit of [value] alone. A [variance] of 0 means unknown.
 */
@Serializable
internal class ScalarMessage(val header: Header, val value: Double, val variance: Double)

/** Returns sensor_msgs/BatteryState; values that the headset does not report are NaN, empty or UNKNOWN. */
internal fun BatterySample.toMessage(header: Header): BatteryState =
    BatteryState(
        header,
        voltage = voltage,
        temperature = temperature,
        current = current,
        charge = Float.NaN,
        capacity = Float.NaN,
        designCapacity = Float.NaN,
        percentage = percentage,
        powerSupplyStatus = status.rosNumber,
        powerSupplyHealth = 0u,
        powerSupplyTechnology = 0u,
        present = true,
        cellVoltage = emptyList(),
        cellTemperature = emptyList(),
        location = "",
        serialNumber = "",
    )

/** Returns the message; docs/topics.md has the order of axes and buttons. */
internal fun InputSample.toMessage(header: Header): Joy = Joy(
    header,
    axes = listOf(trigger, touchX, touchY, force),
    buttons = listOf(bumper, menu, isTouched).map { if (it) 1 else 0 },
)
