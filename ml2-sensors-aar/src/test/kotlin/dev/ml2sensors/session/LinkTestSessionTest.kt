package dev.ml2sensors.session

import kotlinx.serialization.json.jsonObject
import kotlinx.serialization.json.jsonPrimitive
import kotlinx.serialization.json.long
import org.junit.jupiter.api.AfterEach
import org.junit.jupiter.api.Test
import java.util.zip.Deflater
import kotlin.test.assertEquals
import kotlin.test.assertNull
import kotlin.test.assertTrue

/** Link tests in sessions that go on beside them. */
class LinkTestSessionTest {
    private val fixture = SessionFixture()
    private val host = fixture.host

    @AfterEach
    fun close() = fixture.close()

    @Test
    fun streamsGoOnBesideATestAndTheirBooksBalance() {
        val outcome = fixture.run()
        val session = fixture.started("color")
        session.testLink(BYTES)
        repeat(50) { fixture.offer("color/image", payloadBytes = 100_000) }
        repeat(50) { fixture.offer("color/info") }
        assertEquals(BYTES, session.awaitFiller().sumOf { it.body.size })
        fixture.stop.complete("enough")
        session.awaitEnds()
        for (topic in listOf("color/image", "color/info")) {
            assertEquals((0L..49).toList(), session.data(topic).map { it.sequence })
            val counters = session.frames(HostFrame.STATUS).last().json.getValue("channels").jsonObject
            val sent = counters.getValue(topic).jsonObject.getValue("sent").jsonPrimitive.long
            assertEquals(50, sent, topic)
        }
        session.close()
        assertNull(fixture.outcome(outcome))
    }

    @Test
    fun testsFollowOnEachOtherOnOneLane() {
        fixture.run()
        val session = fixture.started()
        for (index in 0..2) {
            session.testLink(BYTES)
            assertEquals((index + 1) * BYTES, session.awaitFiller(index).sumOf { it.body.size })
        }
        assertEquals(1, session.frames(HostFrame.JOIN).count { it.lane == "link_test" })
    }

    @Test
    fun nothingCompressesFiller() {
        fixture.run()
        val session = fixture.started()
        session.testLink(BYTES)
        val filler = session.awaitFiller().map { it.body }.reduce(ByteArray::plus)
        val compressed = Deflater(Deflater.BEST_COMPRESSION).run {
            setInput(filler)
            finish()
            deflate(ByteArray(2 * filler.size))
        }
        assertTrue(compressed > 0.99 * filler.size, "$compressed of ${filler.size}")
    }

    @Test
    fun aSessionThatIsStoppedInATestEndsInOrder() {
        val outcome = fixture.run()
        val session = host.awaitHello()
        session.hold("link_test")
        session.welcome()
        session.configure(1, "{}")
        session.testLink(64 shl 20)
        session.await(HostFrame.JOIN, index = 2)
        fixture.stop.complete("enough")
        fixture.await("stopSources")
        session.release("link_test")
        session.await(HostFrame.BYE)
        session.awaitEnds()
        val ends = session.log().filter { it.kind == HostFrame.END }.map { it.body.decodeToString() }
        assertEquals(setOf("end"), ends.toSet())
        assertTrue(session.awaitFiller().last().body.isEmpty())
        session.close()
        assertNull(fixture.outcome(outcome))
    }

    private companion object {
        const val BYTES = 1_000_000
    }
}
