package dev.ml2sensors.conformance

import dev.ml2sensors.wire.Bye
import dev.ml2sensors.wire.ChannelBody
import dev.ml2sensors.wire.ChannelEnd
import dev.ml2sensors.wire.Close
import dev.ml2sensors.wire.Closed
import dev.ml2sensors.wire.Configure
import dev.ml2sensors.wire.Configured
import dev.ml2sensors.wire.ControlJson
import dev.ml2sensors.wire.ErrorBody
import dev.ml2sensors.wire.Event
import dev.ml2sensors.wire.Failure
import dev.ml2sensors.wire.Frame
import dev.ml2sensors.wire.FrameHeader
import dev.ml2sensors.wire.FrameKind
import dev.ml2sensors.wire.FrameReader
import dev.ml2sensors.wire.FrameWriter
import dev.ml2sensors.wire.Hello
import dev.ml2sensors.wire.Join
import dev.ml2sensors.wire.Joined
import dev.ml2sensors.wire.LinkTestBody
import dev.ml2sensors.wire.Open
import dev.ml2sensors.wire.Opened
import dev.ml2sensors.wire.PairBody
import dev.ml2sensors.wire.PairChallenge
import dev.ml2sensors.wire.Paired
import dev.ml2sensors.wire.Start
import dev.ml2sensors.wire.Status
import dev.ml2sensors.wire.Welcome
import kotlinx.serialization.KSerializer
import kotlinx.serialization.json.Json
import kotlinx.serialization.json.JsonArray
import kotlinx.serialization.json.JsonElement
import kotlinx.serialization.json.JsonNull
import kotlinx.serialization.json.JsonObject
import kotlinx.serialization.json.JsonPrimitive
import kotlinx.serialization.json.int
import kotlinx.serialization.json.jsonArray
import kotlinx.serialization.json.jsonObject
import kotlinx.serialization.json.jsonPrimitive
import kotlinx.serialization.json.long
import org.junit.jupiter.api.DynamicTest
import org.junit.jupiter.api.DynamicTest.dynamicTest
import org.junit.jupiter.api.TestFactory
import java.nio.ByteBuffer
import java.nio.ByteOrder
import java.nio.channels.GatheringByteChannel
import java.nio.channels.ReadableByteChannel
import kotlin.test.assertContentEquals
import kotlin.test.assertEquals
import kotlin.test.assertNull

/** Runs the vectors of tests/conformance/vectors/wire. */
class WireVectorTest {
    @TestFactory
    fun framesAreReadInOnePiece(): List<DynamicTest> = tests { checkReading(it, pieceBytes = it.bytes.size) }

    @TestFactory
    fun framesAreReadByteByByte(): List<DynamicTest> = tests { checkReading(it, pieceBytes = 1) }

    @TestFactory
    fun framesAreWrittenByteForByte(): List<DynamicTest> = tests(::checkWriting)

    @TestFactory
    fun bodiesBecomeTheirClassesAndTheSameJsonAgain(): List<DynamicTest> = tests(::checkBodies)

    private fun tests(check: (Vector) -> Unit): List<DynamicTest> =
        Vector.loadAll("wire").map { dynamicTest(it.name) { check(it) } }

    private fun checkReading(vector: Vector, pieceBytes: Int) {
        val reader = FrameReader(pieces(vector.bytes, pieceBytes))
        if ("ros" in vector.case) reader.maxMessageBytes = FrameKind.MESSAGE.maxLength
        val (known, unknown) = vector.frames.partition { it.name != null }
        for (expected in known) expected.check(checkNotNull(reader.next(FrameKind.entries.toSet())))
        assertNull(reader.next(FrameKind.entries.toSet()))
        assertEquals(unknown.size.toLong(), reader.skipped)
    }

    private fun checkWriting(vector: Vector) {
        var offset = 0
        for (frame in vector.frames) {
            val end = offset + FrameHeader.BYTES + frame.length
            val expected = vector.bytes.copyOfRange(offset, end)
            expected.fill(0, FLAGS_OFFSET, FLAGS_OFFSET + Short.SIZE_BYTES) // readers ignore what writers leave 0
            if (frame.name != null) assertContentEquals(expected, written(frame, expected))
            offset = end
        }
    }

    private fun written(frame: ExpectedFrame, expected: ByteArray): ByteArray {
        val body = expected.copyOfRange(FrameHeader.BYTES, expected.size)
        val target = ByteArrayChannel(expected.size)
        val writer = FrameWriter(target) { frame.field("send") }
        if (frame.name == "DATA") {
            val head = ByteBuffer.allocate(FrameHeader.BYTES)
            frame.header().writeTo(head)
            writer.write(head.flip(), ByteBuffer.wrap(body))
        } else {
            val header = frame.header()
            val kind = checkNotNull(header.kind)
            writer.write(kind, body, header.channel, header.sequence, header.captureNanos)
        }
        return target.bytes()
    }

    private fun checkBodies(vector: Vector) {
        for (frame in vector.frames) {
            val json = frame.json ?: continue
            val again = reencoded(bodySerializers.getValue(checkNotNull(frame.name)), json.toString().toByteArray())
            assertEquals(canonical(json), canonical(again))
        }
    }

    private fun <T> reencoded(serializer: KSerializer<T>, body: ByteArray): JsonElement {
        val value = ControlJson.decode(serializer, body)
        return Json.parseToJsonElement(ControlJson.encode(serializer, value).decodeToString())
    }

    /** Without what a reader ignores, absent for null, and numbers by their value. */
    private fun canonical(json: JsonElement): Any = when (json) {
        is JsonObject -> json.filter { (key, value) ->
            key != IGNORED_KEY && value != JsonNull
        }.mapValues { canonical(it.value) }

        is JsonArray -> json.map(::canonical)

        is JsonPrimitive -> if (json.isString) {
            json.content
        } else {
            json.content.toBigDecimalOrNull()?.stripTrailingZeros()
                ?: json.content
        }
    }

    private fun pieces(bytes: ByteArray, pieceBytes: Int): ReadableByteChannel {
        val source = ByteBuffer.wrap(bytes)
        return object : ReadableByteChannel {
            override fun read(target: ByteBuffer): Int {
                if (!source.hasRemaining()) return -1
                val count = minOf(pieceBytes, target.remaining(), source.remaining())
                target.put(source.slice().limit(count))
                source.position(source.position() + count)
                return count
            }

            override fun isOpen() = true

            override fun close() = Unit
        }
    }

    private companion object {
        const val FLAGS_OFFSET = 4
        const val IGNORED_KEY = "later"
        val bodySerializers =
            mapOf<String, KSerializer<*>>(
                "HELLO" to Hello.serializer(),
                "WELCOME" to Welcome.serializer(),
                "JOIN" to Join.serializer(),
                "JOINED" to Joined.serializer(),
                "CONFIGURE" to Configure.serializer(),
                "CONFIGURED" to Configured.serializer(),
                "CHANNEL" to ChannelBody.serializer(),
                "CHANNEL_END" to ChannelEnd.serializer(),
                "START" to Start.serializer(),
                "LINK_TEST" to LinkTestBody.serializer(),
                "STATUS" to Status.serializer(),
                "ERROR" to ErrorBody.serializer(),
                "BYE" to Bye.serializer(),
                "EVENT" to Event.serializer(),
                "OPEN" to Open.serializer(),
                "OPENED" to Opened.serializer(),
                "CLOSE" to Close.serializer(),
                "CLOSED" to Closed.serializer(),
                "FAILURE" to Failure.serializer(),
                "PAIR_CHALLENGE" to PairChallenge.serializer(),
                "PAIR" to PairBody.serializer(),
                "PAIRED" to Paired.serializer(),
            )
    }
}

/** The expectations of a case for one frame; [name] is null when its kind is unknown. */
private class ExpectedFrame(private val case: JsonObject) {
    val name: String? = case.getValue("name").jsonPrimitive.takeUnless { it is JsonNull }?.content
    val length: Int = case.getValue("length").jsonPrimitive.int
    val json: JsonObject? = case["json"]?.jsonObject

    fun field(name: String): Long = case.getValue(name).jsonPrimitive.long

    fun header(): FrameHeader = FrameHeader(
        field("kind").toInt(),
        length,
        field("channel").toInt(),
        field("sequence").toInt(),
        field("capture"),
        field("send"),
    )

    fun check(found: Frame) {
        assertEquals(name, found.kind.name)
        assertEquals(field("kind"), found.header.kindCode.toLong())
        assertEquals(field("channel"), found.header.channel.toLong())
        assertEquals(field("sequence"), found.header.sequence.toUInt().toLong())
        assertEquals(field("capture"), found.header.captureNanos)
        assertEquals(field("send"), found.header.sendNanos)
        assertEquals(length, found.body.size)
        json?.let { assertEquals(it, Json.parseToJsonElement(found.body.decodeToString())) }
        case["time"]?.jsonObject?.let { times ->
            val body = ByteBuffer.wrap(found.body).order(ByteOrder.LITTLE_ENDIAN)
            assertEquals(times.values.map { it.jsonPrimitive.long }, List(times.size) { body.long })
        }
        case["hex"]?.jsonPrimitive?.let { assertEquals(it.content, found.body.toHexString()) }
    }
}

private val Vector.frames: List<ExpectedFrame>
    get() = case.getValue("frames").jsonArray.map { ExpectedFrame(it.jsonObject) }

/** Takes at most one byte per write, so that a writer has to finish what it began. */
private class ByteArrayChannel(capacity: Int) : GatheringByteChannel {
    private val target = ByteBuffer.allocate(capacity)

    fun bytes(): ByteArray = target.array().copyOf(target.position())

    override fun write(source: ByteBuffer): Int {
        if (!source.hasRemaining()) return 0
        target.put(source.get())
        return 1
    }

    override fun write(sources: Array<out ByteBuffer>, offset: Int, length: Int): Long =
        sources.drop(offset).take(length).firstOrNull { it.hasRemaining() }?.let { write(it).toLong() } ?: 0

    override fun write(sources: Array<out ByteBuffer>): Long = write(sources, 0, sources.size)

    override fun isOpen(): Boolean = true

    override fun close() = Unit
}
