package dev.ml2sensors.message

import dev.ml2sensors.cdr.FixedLength
import kotlinx.serialization.SerialName
import kotlinx.serialization.Serializable

/**
 * A measurement of an inertial unit in its own axes. Covariances are 3x3, row-major, about x, y, z: all zeros mean
 * unknown, and -1 as the first element means that the quantity was not measured. Source: sensor_msgs/msg/Imu, Jazzy.
 *
 * @property header Time of the measurement and frame of the sensor.
 * @property orientation Orientation of the sensor in the world.
 * @property orientationCovariance rad².
 * @property angularVelocity rad/s.
 * @property angularVelocityCovariance rad²/s².
 * @property linearAcceleration Proper acceleration, so 9.81 m/s² upwards at rest.
 * @property linearAccelerationCovariance m²/s⁴.
 */
@Serializable
@SerialName("sensor_msgs/msg/Imu")
public class Imu(
    public val header: Header,
    public val orientation: Quaternion,
    @FixedLength(9) public val orientationCovariance: DoubleArray,
    public val angularVelocity: Vector3,
    @FixedLength(9) public val angularVelocityCovariance: DoubleArray,
    public val linearAcceleration: Vector3,
    @FixedLength(9) public val linearAccelerationCovariance: DoubleArray,
)

/**
 * Magnetic field in the axes of the sensor. Source: sensor_msgs/msg/MagneticField, Jazzy.
 *
 * @property header Time of the measurement and frame of the sensor.
 * @property magneticField Tesla.
 * @property magneticFieldCovariance Tesla²; 3x3, row-major; all zeros mean unknown.
 */
@Serializable
@SerialName("sensor_msgs/msg/MagneticField")
internal class MagneticField(
    val header: Header,
    val magneticField: Vector3,
    @FixedLength(9) val magneticFieldCovariance: DoubleArray,
)

/**
 * State of a joystick or controller. Source: sensor_msgs/msg/Joy, Jazzy.
 *
 * @property header Time of the measurement.
 * @property axes Measurements of the axes, -1 to 1.
 * @property buttons 1 for each pressed button, otherwise 0.
 */
@Serializable
@SerialName("sensor_msgs/msg/Joy")
public data class Joy(
    val header: Header,
    val axes: List<Float>,
    val buttons: List<Int>,
)

/**
 * State of a battery; NaN stands for what is not measured. The numbers of status, health and technology are those of
 * the constants in the `.msg` file, 0 being unknown in each. Source: sensor_msgs/msg/BatteryState, Jazzy.
 *
 * @property header Time of the measurement.
 * @property voltage Volt.
 * @property temperature Degrees Celsius.
 * @property current Ampere; negative when discharging.
 * @property charge Ampere hours left.
 * @property capacity Ampere hours when last full.
 * @property designCapacity Ampere hours when new.
 * @property percentage Fraction left, 0 to 1.
 * @property powerSupplyStatus `POWER_SUPPLY_STATUS_*`.
 * @property powerSupplyHealth `POWER_SUPPLY_HEALTH_*`.
 * @property powerSupplyTechnology `POWER_SUPPLY_TECHNOLOGY_*`.
 * @property present True if there is a battery.
 * @property cellVoltage Volt, per cell.
 * @property cellTemperature Degrees Celsius, per cell.
 * @property location Slot or plug of the battery.
 * @property serialNumber Serial number, as far as known.
 */
@Serializable
@SerialName("sensor_msgs/msg/BatteryState")
public data class BatteryState(
    val header: Header,
    val voltage: Float,
    val temperature: Float,
    val current: Float,
    val charge: Float,
    val capacity: Float,
    val designCapacity: Float,
    val percentage: Float,
    val powerSupplyStatus: UByte,
    val powerSupplyHealth: UByte,
    val powerSupplyTechnology: UByte,
    val present: Boolean,
    val cellVoltage: List<Float>,
    val cellTemperature: List<Float>,
    val location: String,
    val serialNumber: String,
)

/** The states of components, [status], at the time of [header]. Source: diagnostic_msgs/msg/DiagnosticArray, Jazzy. */
@Serializable
@SerialName("diagnostic_msgs/msg/DiagnosticArray")
internal class DiagnosticArray(val header: Header, val status: List<DiagnosticStatus>)

/**
 * The state of a component. Source: diagnostic_msgs/msg/DiagnosticStatus, Jazzy.
 *
 * @property level [OK] or [WARN].
 * @property name of the component.
 * @property message what its state is, for people.
 * @property hardwareId empty.
 * @property values details.
 */
@Serializable
@SerialName("diagnostic_msgs/msg/DiagnosticStatus")
internal data class DiagnosticStatus(
    val level: UByte,
    val name: String,
    val message: String,
    val hardwareId: String,
    val values: List<KeyValue>,
) {
    companion object {
        const val OK: UByte = 0u
        const val WARN: UByte = 1u
    }
}

/** A [value] and what it is of. Source: diagnostic_msgs/msg/KeyValue, Jazzy. */
@Serializable
@SerialName("diagnostic_msgs/msg/KeyValue")
internal data class KeyValue(val key: String, val value: String)
