package dev.ml2sensors.session

import dev.ml2sensors.clock.HostClock
import dev.ml2sensors.wire.ErrorCode
import dev.ml2sensors.wire.Open
import dev.ml2sensors.wire.ProtocolException
import kotlinx.coroutines.CompletableDeferred
import kotlinx.serialization.json.JsonObject
import kotlinx.serialization.json.int
import kotlinx.serialization.json.jsonObject
import kotlinx.serialization.json.jsonPrimitive
import kotlinx.serialization.json.long
import org.junit.jupiter.api.AfterEach
import org.junit.jupiter.api.Test
import kotlin.math.abs
import kotlin.test.assertEquals
import kotlin.test.assertIs
import kotlin.test.assertTrue

/** Tests the session between START and its end. */
class SessionTest {
    private val fixture = SessionFixture()
    private val host = fixture.host

    @AfterEach
    fun close() = fixture.close()

    @Test
    fun pingsAreAnswered() {
        fixture.run()
        val session = fixture.started()
        session.write(HostFrame.PING)
        session.await(HostFrame.PONG)
    }

    @Test
    fun aSilentDevicePings() {
        fixture.run()
        val session = host.awaitHello()
        session.welcome(timeouts = """{"handshake_s": 5, "ping_s": 0.1, "dead_s": 20}""")
        session.await(HostFrame.PING, index = 2)
    }

    @Test
    fun aSilentReceiverIsDeadAndTold() {
        val outcome = fixture.run()
        val session = host.awaitHello()
        session.welcome(timeouts = """{"handshake_s": 5, "ping_s": 0.1, "dead_s": 0.3}""")
        assertEquals("timeout", session.await(HostFrame.ERROR).json.getValue("code").jsonPrimitive.content)
        session.awaitEnd("control")
        session.close()
        assertEquals(ErrorCode.TIMEOUT, assertIs<ProtocolException>(fixture.outcome(outcome)).code)
    }

    @Test
    fun pingsAreAnsweredWhileARequestIsHandledAndRequestsStayInOrder() {
        fixture.streams.configuring = CompletableDeferred()
        fixture.run()
        val session = host.awaitHello()
        session.welcome()
        for (request in 1..2) {
            session.write(HostFrame.CONFIGURE, """{"request": $request, "streams": {"color": {}}}""")
        }
        fixture.await("configure [color]")
        session.write(HostFrame.PING)
        session.await(HostFrame.PONG)
        assertEquals(1, fixture.streams.calls.value.count { it.startsWith("configure") })
        fixture.streams.configuring.complete(Unit)
        val answers = (0..1).map { session.await(HostFrame.CONFIGURED, it).json.getValue("request").jsonPrimitive.int }
        assertEquals(listOf(1, 2), answers)
    }

    @Test
    fun theLanesOfARequestAreJoinedBesideEachOther() {
        host.silentLanes += listOf("color", "depth", "world_left")
        fixture.run()
        val session = host.awaitHello()
        session.welcome()
        val streams = """{"color": {}, "depth": {}, "world_left": {}}"""
        session.write(HostFrame.CONFIGURE, """{"request": 1, "streams": $streams}""")
        val joined = (0..4).map { session.await(HostFrame.JOIN, it).lane }
        assertEquals(setOf("time", "sensors", "color", "depth", "world_left"), joined.toSet())
        for (lane in host.silentLanes) session.write(HostFrame.JOINED, """{"lane": "$lane"}""", lane)
        session.await(HostFrame.CONFIGURED)
    }

    @Test
    fun aBrokenTimeReplyIsToldOnControl() {
        host.silentLanes += "time"
        val outcome = fixture.run()
        val session = host.awaitHello()
        session.welcome()
        session.await(HostFrame.JOIN)
        session.write(HostFrame.JOINED, """{"lane": "time"}""", lane = "time")
        session.configure(1, "{}")
        session.write(HostFrame.TIME_REPLY, "too short", lane = "time")
        assertEquals("malformed", session.await(HostFrame.ERROR).json.getValue("code").jsonPrimitive.content)
        session.close()
        assertEquals(ErrorCode.MALFORMED, assertIs<ProtocolException>(fixture.outcome(outcome)).code)
    }

    @Test
    fun whatBelongsElsewhereIsUnexpectedOnEveryLane() {
        for ((lane, kind) in listOf(
            "control" to HostFrame.DATA,
            "time" to HostFrame.PING,
            "sensors" to HostFrame.BYE,
        )) {
            val outcome = fixture.run()
            val session = fixture.started()
            session.write(kind, lane = lane)
            val error = session.await(HostFrame.ERROR).json
            assertEquals("unexpected", error.getValue("code").jsonPrimitive.content, lane)
            session.close()
            assertEquals(ErrorCode.UNEXPECTED, assertIs<ProtocolException>(fixture.outcome(outcome)).code)
            fixture.streams.calls.value = emptyList()
        }
    }

    @Test
    fun aReceiverWithoutOpeningsIsAskedForNoneAndItsLaterKindsAreSkipped() {
        fixture.run(app = ListedOpenings(Open(1, Open.SUBSCRIPTION, "/scan", "sensor_msgs/msg/LaserScan")))
        assertSkipsOpenings(fixture.started())
    }

    @Test
    fun anAppWithoutOpeningsIgnoresThoseOfTheReceiver() {
        fixture.run()
        val session = host.awaitHello()
        session.welcome(ros = true)
        session.configure(1, "{}")
        assertSkipsOpenings(session)
    }

    private fun assertSkipsOpenings(session: HostSession) {
        session.write(HostFrame.OPENED, "not even JSON")
        session.write(HostFrame.PING)
        session.await(HostFrame.PONG)
        assertEquals(emptyList(), session.frames(HostFrame.OPEN))
        assertEquals(setOf("time", "sensors"), session.frames(HostFrame.JOIN).map { it.lane }.toSet())
    }

    @Test
    fun timeIsExchangedFromTheStart() {
        fixture.run()
        val session = host.awaitHello()
        session.welcome()
        val synchronised = awaitClock(session, "synchronised")
        val error = synchronised.getValue("offset_ns").jsonPrimitive.long - host.clockOffsetNanos
        assertTrue(abs(error) <= synchronised.getValue("uncertainty_ns").jsonPrimitive.long, "$synchronised")
        assertTrue(synchronised.getValue("round_trip_ns").jsonPrimitive.long > 0)
        for (key in listOf("steps", "epoch")) assertEquals(0, synchronised.getValue(key).jsonPrimitive.long, key)
        assertEquals("""{"color":"monotonic"}""", synchronised.getValue("bases").toString())
    }

    @Test
    fun theStatusSaysHowHotTheDeviceIsAndHowWellItPerceives() {
        fixture.run()
        val session = host.awaitHello()
        session.welcome()
        val status = session.await(HostFrame.STATUS).json
        assertEquals("light", status.getValue("thermal").jsonPrimitive.content)
        assertEquals(
            """{"tracking":{"level":"warn","message":"not tracked","values":{"status":"invalid"}}}""",
            status.getValue("conditions").toString(),
        )
    }

    @Test
    fun aReceiverThatNoLongerTellsTheTimeIsToldOfTheHoldover() {
        fixture.run()
        val session = host.awaitHello()
        session.welcome()
        awaitClock(session, "synchronised")
        host.silentLanes += "time"
        awaitClock(session, "holdover")
    }

    @Test
    fun onlyWhatChangesIsAnnouncedAgain() {
        fixture.run()
        val session = fixture.started("color", "depth")
        session.configure(2, """{"color": {}, "world_left": {}}""")
        session.start(2)
        assertEquals(setOf(5, 6), session.ids(HostFrame.CHANNEL_END).toSet())
        session.configure(3, """{"depth": {}}""")
        session.start(3)
        assertEquals(listOf(3, 4, 5, 6, 1, 2, 5, 6), session.ids(HostFrame.CHANNEL))
        val joined = session.frames(HostFrame.JOIN).map { it.lane }
        assertEquals(listOf("time", "sensors"), joined.take(2))
        assertEquals(setOf("color", "depth"), joined.slice(2..3).toSet())
        assertEquals(listOf("world_left"), joined.drop(4))
    }

    @Test
    fun dataThatIsOnItsWayAfterAChannelEndedArrives() {
        fixture.run()
        val session = fixture.started("color")
        session.configure(2, "{}")
        session.start(2)
        fixture.offer("color/image")
        session.awaitData("color/image")
    }

    @Test
    fun aSourceThatFailsEndsItsChannelsAndNoOthers() {
        fixture.run()
        val session = fixture.started("color", "depth")
        fixture.streams.fail("color", "x".repeat(10_000))
        val error = session.await(HostFrame.ERROR).json
        assertEquals("source", error.getValue("code").jsonPrimitive.content)
        assertEquals("false", error.getValue("fatal").jsonPrimitive.content)
        assertTrue(error.getValue("message").jsonPrimitive.content.startsWith("stream color ended: xxx"))
        session.await(HostFrame.CHANNEL_END, index = 1)
        assertEquals(setOf(3, 4), session.ids(HostFrame.CHANNEL_END).toSet())
        fixture.offer("depth/image")
        session.awaitData("depth/image")
        session.configure(2, """{"color": {}, "depth": {}}""")
        assertEquals(setOf(3, 4), session.ids(HostFrame.CHANNEL).drop(4).toSet())
    }

    @Test
    fun aFailureFromBeforeTheSessionEndsNoChannel() {
        fixture.streams.fail("color", "unplugged")
        fixture.run()
        val session = host.awaitHello()
        session.welcome()
        session.await(HostFrame.ERROR)
        session.configure(1, """{"color": {}}""")
        assertEquals(emptyList(), session.frames(HostFrame.CHANNEL_END))
    }

    @Test
    fun theClockIsHeldBetweenSessions() {
        val outcome = fixture.run()
        val session = fixture.started()
        awaitClock(session, "synchronised")
        session.cut()
        fixture.outcome(outcome)
        assertEquals(HostClock.State.HOLDOVER, fixture.clock.status.state)
    }

    private fun awaitClock(session: HostSession, state: String): JsonObject = generateSequence(0) { it + 1 }
        .map { session.await(HostFrame.STATUS, it).json.getValue("clock").jsonObject }
        .first { it.getValue("state").jsonPrimitive.content == state }

    private fun HostSession.ids(kind: Int): List<Int> = frames(kind).map { it.json.getValue("id").jsonPrimitive.int }
}
