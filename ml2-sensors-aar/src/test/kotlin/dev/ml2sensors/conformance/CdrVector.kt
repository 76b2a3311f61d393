package dev.ml2sensors.conformance

import dev.ml2sensors.message.BatteryState
import dev.ml2sensors.message.CameraInfo
import dev.ml2sensors.message.CompressedImage
import dev.ml2sensors.message.CompressedVideo
import dev.ml2sensors.message.Detection3DArray
import dev.ml2sensors.message.DiagnosticArray
import dev.ml2sensors.message.FfmpegPacket
import dev.ml2sensors.message.Header
import dev.ml2sensors.message.Image
import dev.ml2sensors.message.Imu
import dev.ml2sensors.message.Joy
import dev.ml2sensors.message.MagneticField
import dev.ml2sensors.message.Point
import dev.ml2sensors.message.Pose
import dev.ml2sensors.message.PoseArray
import dev.ml2sensors.message.PoseStamped
import dev.ml2sensors.message.PoseWithCovariance
import dev.ml2sensors.message.Quaternion
import dev.ml2sensors.message.RegionOfInterest
import dev.ml2sensors.message.StringMessage
import dev.ml2sensors.message.TFMessage
import dev.ml2sensors.message.Time
import dev.ml2sensors.message.Transform
import dev.ml2sensors.message.TransformStamped
import dev.ml2sensors.message.Vector3
import dev.ml2sensors.message.rosType
import kotlinx.serialization.ExperimentalSerializationApi
import kotlinx.serialization.KSerializer
import kotlinx.serialization.SerialName
import kotlinx.serialization.Serializable
import kotlinx.serialization.json.Json
import kotlinx.serialization.json.JsonArray
import kotlinx.serialization.json.JsonElement
import kotlinx.serialization.json.JsonNamingStrategy
import kotlinx.serialization.json.JsonObject
import kotlinx.serialization.json.JsonPrimitive
import kotlinx.serialization.json.int
import kotlinx.serialization.json.jsonPrimitive

@Serializable
@SerialName("sensor_msgs/msg/Illuminance")
internal class Illuminance(val header: Header, val illuminance: Double, val variance: Double)

@Serializable
@SerialName("sensor_msgs/msg/FluidPressure")
internal class FluidPressure(val header: Header, val fluidPressure: Double, val variance: Double)

internal val MESSAGE_SERIALIZERS: Map<String, KSerializer<*>> =
    listOf(
        Time.serializer(),
        Header.serializer(),
        StringMessage.serializer(),
        Vector3.serializer(),
        Point.serializer(),
        Quaternion.serializer(),
        Pose.serializer(),
        PoseStamped.serializer(),
        PoseArray.serializer(),
        PoseWithCovariance.serializer(),
        Transform.serializer(),
        TransformStamped.serializer(),
        TFMessage.serializer(),
        Image.serializer(),
        CompressedImage.serializer(),
        FfmpegPacket.serializer(),
        CompressedVideo.serializer(),
        CameraInfo.serializer(),
        RegionOfInterest.serializer(),
        Imu.serializer(),
        MagneticField.serializer(),
        Illuminance.serializer(),
        FluidPressure.serializer(),
        BatteryState.serializer(),
        Joy.serializer(),
        Detection3DArray.serializer(),
        DiagnosticArray.serializer(),
    ).associateBy { it.rosType }

/** Fields of a message under their ROS names. */
@OptIn(ExperimentalSerializationApi::class)
internal val fieldsJson =
    Json {
        namingStrategy = JsonNamingStrategy.SnakeCase
        allowSpecialFloatingPointValues = true
    }

/** A case of tests/conformance/vectors/cdr; cdr_vectors.py says what its keys mean. */
internal class CdrVector private constructor(private val vector: Vector) {
    private val fields = vector.case

    @Suppress("UNCHECKED_CAST") // Any message type will do
    val serializer = MESSAGE_SERIALIZERS.getValue(fields.getValue("type").jsonPrimitive.content) as KSerializer<Any>
    val message = fieldsJson.decodeFromJsonElement(serializer, expandPattern(fields.getValue("message")))
    val bytes = vector.bytes
    val size = fields.getValue("size").jsonPrimitive.int
    val prefixSize = fields["prefix_size"]?.jsonPrimitive?.int

    override fun toString() = vector.name

    companion object {
        val all = Vector.loadAll("cdr").map(::CdrVector)

        private fun expandPattern(element: JsonElement): JsonElement = when (element) {
            is JsonObject if "pattern" in element -> {
                check(element.getValue("pattern").jsonPrimitive.content == "index mod 251")
                JsonArray(List(element.getValue("length").jsonPrimitive.int) { JsonPrimitive((it % 251).toByte()) })
            }

            is JsonObject -> {
                JsonObject(element.mapValues { expandPattern(it.value) })
            }

            else -> {
                element
            }
        }
    }
}
