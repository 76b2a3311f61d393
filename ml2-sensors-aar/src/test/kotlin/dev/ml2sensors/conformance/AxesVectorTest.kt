package dev.ml2sensors.conformance

import dev.ml2sensors.message.MlPose
import dev.ml2sensors.message.Quaternion
import dev.ml2sensors.message.Transform
import dev.ml2sensors.message.Vector3
import dev.ml2sensors.message.assertRotation
import dev.ml2sensors.message.assertVector
import kotlinx.serialization.json.Json
import kotlinx.serialization.json.JsonArray
import kotlinx.serialization.json.JsonElement
import kotlinx.serialization.json.JsonObject
import kotlinx.serialization.json.double
import kotlinx.serialization.json.jsonArray
import kotlinx.serialization.json.jsonObject
import kotlinx.serialization.json.jsonPrimitive
import org.junit.jupiter.api.Test
import java.nio.file.Path
import kotlin.io.path.readText

class AxesVectorTest {
    private val poses: JsonArray =
        Json.parseToJsonElement(Path.of("../tests/conformance/vectors/axes/poses.json").readText()).jsonArray

    @Test
    fun bodyPosesAreThoseOfTheVectors() = forEach("ros") { it.toBody() }

    @Test
    fun opticalPosesAreThoseOfTheVectors() = forEach("optical") { it.toOptical() }

    private fun forEach(axes: String, convert: (MlPose) -> Transform) = poses.map { it.jsonObject }.forEach { case ->
        val found = case.getValue("ml").pose().let { convert(MlPose(it.translation, it.rotation)) }
        val expected = case.getValue(axes).pose()
        assertVector(expected.translation, found.translation)
        assertRotation(expected.rotation, found.rotation)
    }

    private fun JsonElement.pose(): Transform {
        val (x, y, z) = jsonObject.numbers("position")
        val q = jsonObject.numbers("rotation")
        return Transform(Vector3(x, y, z), Quaternion(q[0], q[1], q[2], q[3]))
    }

    private fun JsonObject.numbers(key: String) = getValue(key).jsonArray.map { it.jsonPrimitive.double }
}
