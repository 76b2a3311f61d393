package dev.ml2sensors.stream

import dev.ml2sensors.message.Header
import kotlinx.serialization.Serializable

/**
 * FluidPressure, Illuminance, RelativeHumidity or Temperature of sensor_msgs (Jazzy), as the stream table types the
 * topic: they differ in the name and the unit of [value] alone. A [variance] of 0 means unknown.
 */
@Serializable
internal class ScalarMessage(val header: Header, val value: Double, val variance: Double)
