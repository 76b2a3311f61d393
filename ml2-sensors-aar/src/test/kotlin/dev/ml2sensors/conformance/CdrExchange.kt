package dev.ml2sensors.conformance

import dev.ml2sensors.cdr.ByteSequenceSerializer
import dev.ml2sensors.cdr.Cdr
import dev.ml2sensors.cdr.FixedLength
import dev.ml2sensors.cdr.WideStringSerializer
import dev.ml2sensors.cdr.hex
import dev.ml2sensors.cdr.layout
import kotlinx.serialization.ExperimentalSerializationApi
import kotlinx.serialization.KSerializer
import kotlinx.serialization.Serializable
import kotlinx.serialization.SerializationException
import kotlinx.serialization.builtins.DoubleArraySerializer
import kotlinx.serialization.builtins.FloatArraySerializer
import kotlinx.serialization.builtins.IntArraySerializer
import kotlinx.serialization.builtins.ListSerializer
import kotlinx.serialization.builtins.LongArraySerializer
import kotlinx.serialization.builtins.ShortArraySerializer
import kotlinx.serialization.builtins.UIntArraySerializer
import kotlinx.serialization.builtins.ULongArraySerializer
import kotlinx.serialization.builtins.UShortArraySerializer
import kotlinx.serialization.builtins.serializer
import kotlinx.serialization.descriptors.SerialDescriptor
import kotlinx.serialization.descriptors.buildClassSerialDescriptor
import kotlinx.serialization.encoding.Decoder
import kotlinx.serialization.encoding.Encoder
import kotlinx.serialization.json.Json
import kotlinx.serialization.json.JsonElement
import kotlinx.serialization.json.JsonObject
import kotlinx.serialization.json.int
import kotlinx.serialization.json.jsonArray
import kotlinx.serialization.json.jsonObject
import kotlinx.serialization.json.jsonPrimitive
import java.io.File
import java.nio.ByteBuffer

/**
 * Lets test_cdr_exchange.py use the Kotlin library: it writes the layout of each type that ROS describes, and each
 * message as it is after it was read and written.
 */
internal object CdrExchange {
    @Serializable
    private class Asked(val types: Map<String, JsonObject>, val messages: List<Message>)

    @Serializable
    private class Message(val type: String, val bytes: String)

    @Serializable
    private class Answer(val layouts: Map<String, String>, val messages: List<String>)

    @JvmStatic
    fun main(arguments: Array<String>) {
        val (input, output) = arguments.map(::File)
        val asked = Json.decodeFromString<Asked>(input.readText())
        val described = asked.types.mapValues { (type, description) -> DescribedMessage(type, description) }
        val layouts = described.mapValues { it.value.descriptor.layout() }
        for ((type, ours) in MESSAGE_SERIALIZERS) {
            check(layouts[type] in listOf(null, ours.descriptor.layout())) {
                type
            }
        }
        val messages = asked.messages.map { readAndWrite(described.getValue(it.type), it) }
        output.writeText(Json.encodeToString(Answer(layouts, messages)))
    }

    /** By ROS's description; a class of ours must do the same. */
    private fun readAndWrite(described: KSerializer<*>, message: Message): String {
        val results = listOfNotNull(described, MESSAGE_SERIALIZERS[message.type]).map {
            readAndWrite(it, message.bytes)
        }
        return results.distinct().singleOrNull() ?: "differs: $results"
    }

    private fun <T> readAndWrite(serializer: KSerializer<T>, bytes: String): String = try {
        val input = hex(bytes)
        val direct = ByteBuffer.allocateDirect(input.size).put(input).flip()
        Cdr.encodeToByteArray(serializer, Cdr.decode(serializer, direct, allowsTail = true)).toHexString()
    } catch (e: SerializationException) {
        "refused: ${e.message}"
    }
}

/** A message type as `TypeDescription` of ROS has it; its values are lists of the fields' values. */
@OptIn(ExperimentalSerializationApi::class, ExperimentalUnsignedTypes::class)
private class DescribedMessage(type: String, private val description: JsonObject) : KSerializer<List<Any?>> {
    private class Field(val name: String, val serializer: KSerializer<*>, val length: Int?)

    private val types =
        description.getValue("referenced_type_descriptions").jsonArray.plus(description.getValue("type_description"))
            .associateBy { it.jsonObject.getValue("type_name").jsonPrimitive.content }
    private val fields = types.getValue(type).jsonObject.getValue("fields").jsonArray
        .filter { it.name != "structure_needs_at_least_one_member" }
        .map { field(it.name, it.jsonObject.getValue("type").jsonObject) }

    override val descriptor: SerialDescriptor = buildClassSerialDescriptor(type) {
        for (field in fields) {
            element(field.name, field.serializer.descriptor, listOfNotNull(field.length?.let { FixedLength(it) }))
        }
    }

    private val JsonElement.name get() = jsonObject.getValue("name").jsonPrimitive.content

    private fun field(name: String, type: JsonObject): Field {
        val id = type.getValue("type_id").jsonPrimitive.int
        val nested = type.getValue("nested_type_name").jsonPrimitive.content
        return when (id / IDS) {
            0 -> Field(name, element(id, nested), null)
            1 -> Field(name, array(id % IDS, nested), type.getValue("capacity").jsonPrimitive.int)
            else -> Field(name, array(id % IDS, nested), null)
        }
    }

    private fun array(id: Int, nested: String): KSerializer<*> = when (id) {
        3, 16 -> ByteSequenceSerializer
        4 -> ShortArraySerializer()
        5 -> UShortArraySerializer()
        6 -> IntArraySerializer()
        7 -> UIntArraySerializer()
        8 -> LongArraySerializer()
        9 -> ULongArraySerializer()
        10 -> FloatArraySerializer()
        11 -> DoubleArraySerializer()
        else -> ListSerializer(element(id, nested))
    }

    private fun element(id: Int, nested: String): KSerializer<*> = when (id) {
        1 -> DescribedMessage(nested, description)
        2 -> Byte.serializer()
        3, 13, 16 -> UByte.serializer()
        4 -> Short.serializer()
        5 -> UShort.serializer()
        6 -> Int.serializer()
        7 -> UInt.serializer()
        8 -> Long.serializer()
        9 -> ULong.serializer()
        10 -> Float.serializer()
        11 -> Double.serializer()
        15 -> Boolean.serializer()
        17, 21 -> String.serializer()
        18, 22 -> WideStringSerializer
        else -> error("type $id")
    }

    override fun serialize(encoder: Encoder, value: List<Any?>) {
        val structure = encoder.beginStructure(descriptor)
        for ((index, field) in fields.withIndex()) {
            @Suppress("UNCHECKED_CAST") // It encodes only the values that it decoded
            structure.encodeSerializableElement(descriptor, index, field.serializer as KSerializer<Any?>, value[index])
        }
        structure.endStructure(descriptor)
    }

    override fun deserialize(decoder: Decoder): List<Any?> {
        val structure = decoder.beginStructure(descriptor)
        val values =
            fields.mapIndexed { index, field ->
                structure.decodeSerializableElement(descriptor, index, field.serializer)
            }
        structure.endStructure(descriptor)
        return values
    }

    private companion object {
        /** From a type to the array of it, the bounded and the unbounded sequence. */
        const val IDS = 48
    }
}
