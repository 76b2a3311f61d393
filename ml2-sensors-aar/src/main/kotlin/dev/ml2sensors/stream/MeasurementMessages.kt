package dev.ml2sensors.stream

import dev.ml2sensors.message.BatteryState
import dev.ml2sensors.message.BoundingBox3D
import dev.ml2sensors.message.Detection3D
import dev.ml2sensors.message.Detection3DArray
import dev.ml2sensors.message.Header
import dev.ml2sensors.message.Joy
import dev.ml2sensors.message.ObjectHypothesis
import dev.ml2sensors.message.ObjectHypothesisWithPose
import dev.ml2sensors.message.PoseWithCovariance
import dev.ml2sensors.message.Vector3
import dev.ml2sensors.message.toPose
import dev.ml2sensors.source.BatterySample
import dev.ml2sensors.source.InputSample
import dev.ml2sensors.source.Marker
import dev.ml2sensors.source.MarkersSample
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

/** Returns the message; docs/topics.md says what its fields have of a marker. */
internal fun MarkersSample.toMessage(header: Header, frameIds: FrameIds): Detection3DArray =
    Detection3DArray(header, markers.map { it.toDetection(header, frameIds.ofMarker(it.frame)) })

private fun Marker.toDetection(header: Header, frame: String): Detection3D {
    val covariance = DoubleArray(POSE_COVARIANCE)
    for (axis in 0 until 3) covariance[axis * POSE_AXES + axis] = reprojectionErrorM * reprojectionErrorM
    val result = ObjectHypothesisWithPose(ObjectHypothesis(content, 1.0), PoseWithCovariance(pose.toPose(), covariance))
    return Detection3D(header, listOf(result), BoundingBox3D(pose.toPose(), Vector3(sizeM, sizeM, 0.0)), frame)
}

private const val POSE_AXES = 6
private const val POSE_COVARIANCE = POSE_AXES * POSE_AXES
