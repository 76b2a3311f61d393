package dev.ml2sensors.unity

import dev.ml2sensors.TEST_LIMIT
import dev.ml2sensors.capture.CaptureFixture
import dev.ml2sensors.capture.Native
import dev.ml2sensors.capture.Simulation
import dev.ml2sensors.message.SetBool
import dev.ml2sensors.message.Time
import dev.ml2sensors.ros.ServiceException
import dev.ml2sensors.session.HostFrame
import dev.ml2sensors.session.HostSession
import dev.ml2sensors.stream.StreamFixture
import dev.ml2sensors.table.StreamTable
import kotlinx.coroutines.CoroutineScope
import kotlinx.coroutines.Dispatchers
import kotlinx.coroutines.SupervisorJob
import kotlinx.coroutines.cancel
import kotlinx.coroutines.delay
import kotlinx.coroutines.runBlocking
import kotlinx.coroutines.withTimeout
import kotlinx.serialization.json.jsonPrimitive
import org.junit.jupiter.api.AfterEach
import org.junit.jupiter.api.Test
import java.nio.ByteBuffer
import java.nio.ByteOrder
import kotlin.test.assertContains
import kotlin.test.assertContentEquals
import kotlin.test.assertEquals
import kotlin.test.assertFailsWith
import kotlin.time.Duration
import kotlin.time.Duration.Companion.milliseconds

/** Tests what a receiver gets of messages that C# puts into outboxes. */
class UnityPublishersTest {
    private val native = CaptureFixture()
    private val fixture = StreamFixture()
    private val publishers = UnityPublishers()
    private val mapped = Native.mappedBytes()

    @AfterEach
    fun close() {
        publishers.close()
        fixture.close()
        // A thread gives its last message back after it was sent
        runBlocking { withTimeout(TEST_LIMIT) { while (Native.mappedBytes() != mapped) delay(1.milliseconds) } }
        native.close()
    }

    @Test
    fun messagesArriveWhetherTheirTopicIsOpenedBeforeOrAfterTheStart() {
        val before = open("custom/before")
        publishers.use(fixture.streamer)
        val session = fixture.start(CUSTOM)
        val after = open("custom/after")
        assertEquals(after, open("after"))
        session.await(HostFrame.CHANNEL, 1)
        session.start(1)
        for ((outbox, topic) in mapOf(before to "custom/before", after to "custom/after")) {
            val captureNanos = fixture.now
            session.awaitWhile(topic) { add(outbox, message(1), captureNanos) }
            val frame = session.awaitData(topic).first()
            assertContentEquals(message(1), frame.body)
            assertEquals(fixture.streamer.stampNanos(captureNanos), frame.captureNanos)
        }
        fixture.finish(session)
    }

    @Test
    fun aHeaderHasTheRosTimeOfTheCapture() {
        val outbox = publishers.open("pose", TYPE, false, false, true, 10)
        publishers.use(fixture.streamer)
        val session = fixture.start(CUSTOM)
        session.awaitWhile("custom/pose") { add(outbox, message(7) + ByteArray(20), fixture.now) }
        val frame = session.awaitData("custom/pose").first()
        val body = ByteBuffer.wrap(frame.body).order(ByteOrder.LITTLE_ENDIAN)
        assertEquals(Time.ofNanos(frame.captureNanos), Time(body.getInt(4), body.getInt(8).toUInt()))
        assertContentEquals(ByteArray(16), frame.body.drop(12).toByteArray())
        fixture.finish(session)
    }

    @Test
    fun latchedLargeAndAbsoluteTopicsAreAnnouncedAsSuch() {
        val outbox = publishers.open("/map", TYPE, true, true, false, 1)
        publishers.use(fixture.streamer)
        val session = fixture.start(CUSTOM, ros = true)
        val channel = session.channels().getValue("/map")
        assertEquals(
            listOf("latched", "custom"),
            listOf("qos", "lane").map {
                channel.getValue(it).jsonPrimitive.content
            },
        )
        val large = message(1) + ByteArray(1 shl 20)
        session.awaitWhile("/map") { add(outbox, large, fixture.now) }
        assertContentEquals(large, session.awaitData("/map").first().body)
        fixture.finish(session)
    }

    @Test
    fun aTopicThatCannotBeIsRefusedAtOnce() {
        for ((topic, type) in listOf("not/one" to TYPE, "one" to "Float32", "//one" to TYPE)) {
            assertFailsWith<IllegalArgumentException>(topic) { publishers.open(topic, type, false, false, false, 1) }
        }
        repeat(StreamTable.customTopics.maxTopics) { open("topic$it") }
        assertFailsWith<IllegalStateException> { open("one") }
        assertFailsWith<IllegalArgumentException> { publishers.open("topic1", TYPE, true, false, false, 1) }
    }

    @Test
    fun aTopicThatTheReceiverDoesNotPublishSaysWhy() = runBlocking<Unit> {
        val thing = open("thing")
        assertEquals("", publishers.refusal(thing))
        publishers.use(fixture.streamer)
        val session = fixture.start(CUSTOM)
        val id = session.channels().getValue("custom/thing").getValue("id")
        session.write(
            HostFrame.ERROR,
            """{"code": "channel", "message": "no such type", "fatal": false, "channel": $id}""",
        )
        withTimeout(TEST_LIMIT) { while (publishers.refusal(thing) != "no such type") delay(1.milliseconds) }
    }

    /** Acts until a message of [topic] has come: before the receiver has opened it, messages are dropped. */
    private fun HostSession.awaitWhile(topic: String, act: () -> Unit) = runBlocking {
        withTimeout(TEST_LIMIT) {
            while (data(topic).isEmpty()) {
                act()
                delay(1.milliseconds)
            }
        }
    }

    private fun open(topic: String) = publishers.open(topic, TYPE, false, false, false, 10)

    private fun message(value: Byte) = byteArrayOf(0, 1, 0, 0, value, 0, 0, 0)

    /** As C# does. */
    private fun add(outbox: Int, message: ByteArray, captureNanos: Long) =
        Native.addMessage(outbox, message, 0, message.size, captureNanos, 0)

    private companion object {
        const val TYPE = "my_msgs/msg/Thing"
        const val CUSTOM = """{"custom": {}}"""
    }
}

/** Tests what C# finds of the services that it calls, and nodes of ROS of those that it offers. */
class UnityServicesTest {
    private val native = CaptureFixture()
    private val fixture = StreamFixture()
    private val scope = CoroutineScope(SupervisorJob() + Dispatchers.Default)
    private val services = UnityServices(scope)

    @AfterEach
    fun close() {
        services.close()
        scope.cancel()
        fixture.close()
        native.close()
    }

    @Test
    fun aCallThatBeginsBeforeTheSessionHasItsResponseOrTheReasonOfItsFailure() {
        services.use(fixture.streamer)
        val client = services.call("/pause", SetBool.name)
        val responses = services.inbox(client)
        call(client, number = 7, TEST_LIMIT)
        val session = fixture.start("{}", ros = true)
        val open = session.await(HostFrame.OPEN).json
        assertEquals(
            listOf("client", "/pause", SetBool.name, null),
            listOf("kind", "name", "type", "layout").map { open[it]?.jsonPrimitive?.content },
        )
        session.write(HostFrame.OPENED, """{"id": 1, "result": "opened", "lane": "ros", "name": "/pause"}""")
        val request = session.await(HostFrame.REQUEST)
        assertContentEquals(REQUEST, request.body)
        session.send(HostFrame.RESPONSE, 1, request.sequence.toInt(), RESPONSE)
        assertContentEquals(RESPONSE, taken(responses))
        val failures = listOf("unavailable", "timeout", "refused", "malformed", "too_large", "busy", "link_down", "new")
        for ((index, code) in failures.withIndex()) {
            call(client, number = 8 + index, TEST_LIMIT)
            val failed = session.await(HostFrame.REQUEST, 1 + index)
            val failure = """{"code": "$code", "message": "no"}""".encodeToByteArray()
            session.send(HostFrame.FAILURE, 1, failed.sequence.toInt(), failure)
            val answer = taken(responses)
            assertEquals(1 + index, answer[0].toInt(), code)
            assertEquals("/pause: no", answer.drop(1).toByteArray().decodeToString())
        }
    }

    @Test
    fun aCallBeforeTheStartAndOneThatIsLateFail() {
        val client = services.call("/pause", SetBool.name)
        call(client, number = 1, TEST_LIMIT)
        assertEquals("the streamer is not started", reason(client, ServiceException.Reason.LINK_DOWN))
        services.use(fixture.streamer)
        call(client, number = 2, 1.milliseconds)
        assertContains(reason(client, ServiceException.Reason.LINK_DOWN), "no connection for 1ms")
    }

    @Test
    fun aServiceThatCannotBeIsRefusedAtOnce() {
        assertFailsWith<IllegalArgumentException> { services.offer("/pause", "std_srvs/SetBool") }
        assertFailsWith<IllegalArgumentException> { services.call("/pause", "std_srvs/SetBool") }
        assertFailsWith<IllegalArgumentException> { services.call("", SetBool.name) }
    }

    private fun reason(client: Int, expected: ServiceException.Reason): String {
        val answer = taken(services.inbox(client))
        assertEquals(expected.ordinal + 1, answer[0].toInt())
        return answer.drop(1).toByteArray().decodeToString()
    }

    /** As C# does. */
    private fun call(client: Int, number: Int, timeout: Duration) =
        Native.addMessage(client, REQUEST, 0, REQUEST.size, timeout.inWholeNanoseconds, number)

    @Test
    fun requestsAreAnsweredByTheirNumbersOrFail() {
        val server = services.offer("custom/pause", SetBool.name)
        val requests = services.inbox(server)
        services.use(fixture.streamer)
        val session = fixture.start("{}", ros = true)
        val open = session.await(HostFrame.OPEN).json
        assertEquals(
            listOf("service", "custom/pause", SetBool.name, null),
            listOf("kind", "name", "type", "layout").map { open[it]?.jsonPrimitive?.content },
        )
        session.write(HostFrame.OPENED, """{"id": 1, "result": "opened", "lane": "ros", "name": "/pause"}""")
        for (number in 1..2) {
            session.send(HostFrame.REQUEST, 1, 40 + number, REQUEST, TEST_LIMIT.inWholeNanoseconds)
            assertContentEquals(REQUEST, taken(requests))
        }
        respond(server, "\u0001no way".encodeToByteArray(), number = 2)
        respond(server, RESPONSE, number = 9)
        respond(server, RESPONSE, number = 1)
        val failure = session.await(HostFrame.FAILURE)
        assertEquals(42, failure.sequence.toInt())
        assertContains(failure.json.getValue("message").jsonPrimitive.content, "no way")
        val response = session.await(HostFrame.RESPONSE)
        assertEquals(41, response.sequence.toInt())
        assertContentEquals(RESPONSE, response.body)
    }

    @Test
    fun aServiceThatRosDoesNotHaveSaysWhy() = runBlocking<Unit> {
        val server = services.offer("/pause", SetBool.name)
        assertEquals("", services.refusal(server))
        services.use(fixture.streamer)
        val session = fixture.start("{}", ros = true)
        session.await(HostFrame.OPEN)
        session.write(HostFrame.OPENED, """{"id": 1, "result": "refused", "reason": "no rule"}""")
        withTimeout(TEST_LIMIT) { while (services.refusal(server) != "no rule") delay(1.milliseconds) }
    }

    /** As C# does. */
    private fun respond(server: Int, bytes: ByteArray, number: Int) =
        Native.addMessage(server, bytes, 0, bytes.size, 0, number)
}

private val REQUEST = byteArrayOf(0, 1, 0, 0, 1)
private val RESPONSE = byteArrayOf(0, 1, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0)

/** Takes the next message of an inbox as C# does. */
private fun taken(inbox: Int): ByteArray = runBlocking {
    withTimeout(TEST_LIMIT) {
        var message: ByteArray? = null
        while (message == null) {
            delay(1.milliseconds)
            message = Simulation.takeMessage(inbox)
        }
        message
    }
}
