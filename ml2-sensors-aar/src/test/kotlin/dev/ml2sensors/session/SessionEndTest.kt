package dev.ml2sensors.session

import kotlinx.coroutines.CompletableDeferred
import kotlinx.coroutines.cancelAndJoin
import kotlinx.coroutines.flow.first
import kotlinx.coroutines.runBlocking
import kotlinx.coroutines.withTimeoutOrNull
import kotlinx.serialization.json.JsonObject
import kotlinx.serialization.json.jsonObject
import kotlinx.serialization.json.jsonPrimitive
import kotlinx.serialization.json.long
import org.junit.jupiter.api.AfterEach
import org.junit.jupiter.api.Test
import java.io.IOException
import kotlin.test.assertEquals
import kotlin.test.assertFalse
import kotlin.test.assertIs
import kotlin.test.assertNull
import kotlin.test.assertTrue
import kotlin.time.Duration.Companion.milliseconds

class SessionEndTest {
    private val fixture = SessionFixture()
    private val host = fixture.host

    @AfterEach
    fun close() = fixture.close()

    @Test
    fun anOrderlyEndSendsEverythingThenTheBooksThenBye() {
        val outcome = fixture.run()
        val session = fixture.started("color")
        repeat(90) { fixture.offer("color/image", payloadBytes = 10_000) }
        repeat(90) { fixture.offer("color/info") }
        fixture.stop.complete("enough")
        val bye = session.await(HostFrame.BYE)
        assertEquals("enough", bye.json.getValue("reason").jsonPrimitive.content)
        session.awaitEnds()
        assertEquals((0L..89).toList(), session.data("color/image").map { it.sequence })
        assertEquals((0L..89).toList(), session.data("color/info").map { it.sequence })
        val last = session.log().filter { it.lane == "control" }.takeLast(3)
        assertEquals(listOf(HostFrame.STATUS, HostFrame.BYE, HostFrame.END), last.map { it.kind })
        assertEquals("true", last[0].json.getValue("final").jsonPrimitive.content)
        for (topic in listOf("color/image", "color/info")) assertEquals(Triple(90L, 90L, 0L), counters(last[0], topic))
        session.close()
        assertNull(fixture.outcome(outcome))
        assertEquals("stopSources", fixture.streams.calls.value.last())
    }

    @Test
    fun theRequestBeingHandledEndsBeforeTheSourcesStopAndNoneFollows() {
        val outcome = fixture.run()
        val session = fixture.started("color")
        fixture.streams.configuring = CompletableDeferred()
        session.write(HostFrame.CONFIGURE, """{"request": 2, "streams": {"depth": {}}}""")
        session.write(HostFrame.START, """{"request": 2, "channels": 4}""")
        fixture.await("configure [depth]")
        fixture.stop.complete("enough")
        val early = runBlocking {
            withTimeoutOrNull(200.milliseconds) { fixture.streams.calls.first { "stopSources" in it } }
        }
        assertNull(early, "while a request is handled")
        fixture.streams.configuring.complete(Unit)
        session.await(HostFrame.BYE)
        val calls = fixture.streams.calls.value
        assertEquals(listOf("configure [depth]", "stopSources"), calls.takeLast(2))
        assertEquals(1, calls.count { it == "start" })
        session.close()
        assertNull(fixture.outcome(outcome))
    }

    @Test
    fun thereIsOneFinalStatus() {
        val outcome = fixture.run()
        val session = fixture.started()
        session.await(HostFrame.STATUS)
        fixture.stop.complete("enough")
        session.await(HostFrame.BYE)
        val finals = session.frames(HostFrame.STATUS).map { it.json.getValue("final").jsonPrimitive.content }
        assertEquals(listOf("true"), finals.filter { it == "true" })
        session.close()
        assertNull(fixture.outcome(outcome))
    }

    @Test
    fun howAReceiverLeavesAfterByeDoesNotMatter() {
        val leaving = listOf<HostSession.() -> Unit>(
            { close() },
            { cut() },
            { write(HostFrame.BYE, """{"reason": "you too"}""") },
            {
                repeat(5) { write(HostFrame.PING) }
                closeOutput("time")
                closeOutput("sensors")
                closeOutput("control")
            },
        )
        for (leave in leaving) {
            SessionFixture().use { ending ->
                ending.host.closesAfterBye = false
                val outcome = ending.run()
                val session = ending.started("color")
                ending.stop.complete("enough")
                session.await(HostFrame.BYE)
                session.leave()
                assertNull(ending.outcome(outcome))
                assertEquals(emptyList(), session.frames(HostFrame.PONG), "nothing follows BYE")
            }
        }
    }

    @Test
    fun whatCannotBeSentInTimeIsDroppedAndCounted() {
        SessionFixture(drainLimit = 100.milliseconds).use { slow ->
            val outcome = slow.run()
            val session = slow.started("color", held = "color")
            repeat(20) { slow.offer("color/image", payloadBytes = 4 shl 20) }
            slow.offer("color/info")
            session.awaitData("color/info")
            slow.stop.complete("enough")
            session.await(HostFrame.BYE)
            val status = session.frames(HostFrame.STATUS).last()
            val (produced, sent, dropped) = counters(status, "color/image")
            assertEquals(20, produced)
            assertEquals(produced, sent + dropped)
            assertTrue(dropped > 0)
            assertEquals(Triple(1L, 1L, 0L), counters(status, "color/info"))
            session.close()
            assertNull(slow.outcome(outcome))
        }
    }

    @Test
    fun noLaneEndsWhileAnotherIsStillSending() {
        SessionFixture().use { slow ->
            val outcome = slow.run()
            val session = slow.started("color", held = "color")
            repeat(20) { slow.offer("color/image", payloadBytes = 4 shl 20) }
            slow.stop.complete("enough")
            slow.await("stopSources")
            session.await(HostFrame.STATUS, session.frames(HostFrame.STATUS).size)
            assertEquals(emptyList(), session.frames(HostFrame.END))
            session.release("color")
            val status = session.await(HostFrame.BYE).let { session.frames(HostFrame.STATUS).last() }
            assertEquals(Triple(20L, 20L, 0L), counters(status, "color/image"))
            session.close()
            assertNull(slow.outcome(outcome))
        }
    }

    @Test
    fun aReceiverThatSaysByeEndsTheSession() {
        val outcome = fixture.run()
        val session = fixture.started("color")
        session.write(HostFrame.BYE, """{"reason": "replaced"}""")
        assertTrue("replaced" in assertIs<IOException>(fixture.outcome(outcome)).message.orEmpty())
        for (lane in listOf("control", "time", "sensors", "color")) session.awaitEnd(lane)
    }

    @Test
    fun theEndOfControlWithoutByeIsALoss() {
        val outcome = fixture.run()
        val session = fixture.started("color")
        session.closeOutput("control")
        assertIs<IOException>(fixture.outcome(outcome))
        for (lane in listOf("control", "time", "sensors", "color")) session.awaitEnd(lane)
    }

    @Test
    fun framesUnderWayWhenTheLinkBreaksAreSettledInTheNextSession() {
        val first = fixture.run()
        val session = fixture.started("color", held = "color")
        repeat(50) { fixture.offer("color/image", payloadBytes = 1 shl 20) }
        session.cut()
        assertIs<IOException>(fixture.outcome(first))
        fixture.offer("color/image")
        fixture.streams.calls.value = emptyList()
        val second = fixture.run()
        val again = fixture.started("color")
        fixture.offer("color/image")
        again.awaitData("color/image")
        fixture.stop.complete("enough")
        again.await(HostFrame.BYE)
        val (produced, sent, dropped) = counters(again.frames(HostFrame.STATUS).last(), "color/image")
        assertEquals(52, produced)
        assertEquals(host.received()["color/image"], sent)
        assertEquals(produced, sent + dropped)
        assertEquals(51, again.data("color/image").single().sequence, "numbers go on across sessions")
        again.close()
        assertNull(fixture.outcome(second))
    }

    @Test
    fun cancellingLeavesNoConnection() {
        val outcome = fixture.run()
        val session = fixture.started("color")
        runBlocking { outcome.cancelAndJoin() }
        for (lane in listOf("control", "time", "sensors", "color")) session.awaitEnd(lane)
        assertFalse(outcome.isActive)
    }

    /** Produced, sent and dropped of [topic]. */
    private fun counters(status: HostFrame, topic: String): Triple<Long, Long, Long> {
        val counts: JsonObject = status.json.getValue("channels").jsonObject.getValue(topic).jsonObject
        val dropped = counts.getValue("dropped").jsonObject.values.sumOf { it.jsonPrimitive.long }
        return Triple(
            counts.getValue("produced").jsonPrimitive.long,
            counts.getValue("sent").jsonPrimitive.long,
            dropped,
        )
    }
}
