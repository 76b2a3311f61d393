package dev.ml2sensors.session

import dev.ml2sensors.wire.ErrorCode
import dev.ml2sensors.wire.ProtocolException
import kotlinx.coroutines.Deferred
import kotlinx.serialization.json.Json
import kotlinx.serialization.json.jsonPrimitive
import org.junit.jupiter.api.AfterEach
import org.junit.jupiter.api.Test
import java.io.IOException
import kotlin.test.assertEquals
import kotlin.test.assertIs
import kotlin.test.assertTrue

class SessionHandshakeTest {
    private val fixture = SessionFixture()
    private val host = fixture.host

    @AfterEach
    fun close() = fixture.close()

    @Test
    fun theDeviceSaysWhoItIs() {
        fixture.run()
        val expected =
            """{"versions": [1], "device_id": "device", "instance_id": "instance", "name": "Größe", "software": "test",
                "capabilities": {"streams": ["world_left", "color", "depth"]}, "permissions": {"camera": true}}"""
        assertEquals(Json.parseToJsonElement(expected), host.awaitHello().hello.json)
    }

    @Test
    fun connectionsAndFramesComeInTheOrderOfTheProtocol() {
        fixture.run()
        val session = host.awaitHello()
        session.welcome(mapOf("world_left/image" to 3))
        val answers = session.configure(7, """{"world_left": {"update_rate": 30}, "absent": {}}""")
        assertEquals(
            Json.parseToJsonElement(
                """{"world_left": {"result": "adjusted", "values": {"update_rate": 5}, "reason": "5 Hz is all"},
                    "absent": {"result": "refused", "reason": "not there"}}""",
            ),
            answers,
        )
        val handshake = session.log().filter { it.kind != HostFrame.STATUS }
        val joined = handshake.filter { it.kind == HostFrame.JOIN }.map { it.lane }
        assertEquals(listOf("time", "sensors", "world_left"), joined)
        val control = handshake.filter { it.lane == "control" }.map { it.kind }
        assertEquals(listOf(HostFrame.CHANNEL, HostFrame.CHANNEL, HostFrame.CONFIGURED), control)
        session.start(7)
        fixture.await("start")
        val calls =
            listOf("beginSession {world_left/image=3}", "welcome scripted", "configure [world_left, absent]", "start")
        assertEquals(calls, fixture.streams.calls.value)
        fixture.offer("world_left/image")
        session.awaitData("world_left/image")
    }

    @Test
    fun channelsSayWhatTheTableSays() {
        fixture.run()
        val session = fixture.started("color")
        val expected =
            """{"id": 3, "stream": "color", "role": "image", "topic": "color/image", "type": "some/msg/Type",
                "qos": "image", "frame_id": "frame", "lane": "color"}"""
        assertEquals(Json.parseToJsonElement(expected), session.channels().getValue("color/image"))
    }

    @Test
    fun nothingIsSentBeforeStart() {
        fixture.run()
        val session = host.awaitHello()
        session.welcome()
        session.configure(1, """{"color": {}}""")
        repeat(5) { fixture.offer("color/image") }
        session.start(1)
        fixture.await("start")
        fixture.offer("color/image")
        assertEquals(5, session.awaitData("color/image").first().sequence)
        assertEquals(mapOf("link_down" to 5L), fixture.streams.counts().getValue("color/image").dropped)
    }

    @Test
    fun aBusyReceiverIsNotAnswered() {
        val outcome = fixture.run()
        val session = host.awaitHello()
        session.write(HostFrame.ERROR, """{"code": "busy", "message": "another is connected", "fatal": true}""")
        val error = assertIs<ProtocolException>(fixture.outcome(outcome))
        assertEquals(ErrorCode.BUSY to true, error.code to error.isPeers)
        assertTrue("another is connected" in error.message.orEmpty())
        session.awaitEnd("control")
        assertEquals(emptyList(), session.frames(HostFrame.ERROR))
    }

    @Test
    fun errorsThatAreNotFatalArePassedOver() {
        fixture.run()
        val session = host.awaitHello()
        session.write(HostFrame.ERROR, """{"code": "new", "message": "careful", "fatal": false}""")
        session.welcome()
        session.write(HostFrame.ERROR, """{"code": "new", "message": "careful", "fatal": false}""")
        session.configure(1, "{}")
    }

    @Test
    fun aLaneThatIsNotAnsweredTimesOut() {
        for (lane in listOf("time", "sensors", "color")) {
            host.silentLanes += lane
            val outcome = fixture.run()
            val session = host.awaitHello()
            session.welcome(timeouts = """{"handshake_s": 0.2, "ping_s": 1, "dead_s": 20}""")
            if (lane == "color") session.write(HostFrame.CONFIGURE, """{"request": 1, "streams": {"color": {}}}""")
            assertTold(ErrorCode.TIMEOUT, session, outcome)
            host.silentLanes.clear()
        }
    }

    @Test
    fun aLaneWithoutATicketEndsTheSession() {
        val outcome = fixture.run()
        val session = host.awaitHello()
        session.welcome(lanes = listOf("time", "sensors"))
        session.write(HostFrame.CONFIGURE, """{"request": 1, "streams": {"color": {}}}""")
        assertTold(ErrorCode.TICKET, session, outcome)
    }

    @Test
    fun aHostWithoutAnAddressIsAFailureOfTheWorld() {
        val failure = assertIs<IOException>(fixture.outcome(fixture.run(ReceiverAddress("no-such-host.invalid", 1))))
        assertTrue("no-such-host.invalid" in failure.message.orEmpty())
    }

    @Test
    fun aRefusedConnectionIsAFailureOfTheWorld() {
        fixture.close()
        assertIs<IOException>(fixture.outcome(SessionFixture().use { it.run(host.address).also(fixture::outcome) }))
    }

    private fun assertTold(code: ErrorCode, session: HostSession, outcome: Deferred<Throwable?>) {
        val error = session.await(HostFrame.ERROR).json
        assertEquals(code.wireName, error.getValue("code").jsonPrimitive.content, "$error")
        assertEquals("true", error.getValue("fatal").jsonPrimitive.content)
        session.awaitEnd("control")
        session.close()
        assertEquals(code, assertIs<ProtocolException>(fixture.outcome(outcome)).code)
    }
}
