package dev.ml2sensors.stream

import dev.ml2sensors.message.BatteryState
import dev.ml2sensors.message.Header
import dev.ml2sensors.source.BatterySample

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
