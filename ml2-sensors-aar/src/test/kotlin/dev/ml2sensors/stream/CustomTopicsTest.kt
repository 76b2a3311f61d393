package dev.ml2sensors.stream

import dev.ml2sensors.TEST_LIMIT
import dev.ml2sensors.clock.HostClock
import dev.ml2sensors.clock.TimeExchange
import dev.ml2sensors.session.HostFrame
import dev.ml2sensors.source.defaultValues
import dev.ml2sensors.table.StreamTable
import kotlinx.coroutines.delay
import kotlinx.coroutines.runBlocking
import kotlinx.coroutines.test.StandardTestDispatcher
import kotlinx.coroutines.test.TestScope
import kotlinx.coroutines.test.runTest
import kotlinx.coroutines.withTimeout
import kotlinx.coroutines.yield
import kotlinx.serialization.json.JsonObject
import kotlinx.serialization.json.jsonObject
import kotlinx.serialization.json.jsonPrimitive
import org.junit.jupiter.api.AfterEach
import org.junit.jupiter.api.Test
import java.nio.ByteBuffer
import kotlin.math.abs
import kotlin.test.assertContains
import kotlin.test.assertContentEquals
import kotlin.test.assertEquals
import kotlin.test.assertFailsWith
import kotlin.test.assertFalse
import kotlin.test.assertSame
import kotlin.test.assertTrue
import kotlin.time.Duration.Companion.microseconds
import kotlin.time.Duration.Companion.milliseconds
import kotlin.time.Duration.Companion.seconds

/** Topics of the app's own, as a receiver sees them. */
class CustomTopicsTest {
    private val fixture = StreamFixture()

    @AfterEach
    fun close() = fixture.close()

    @Test
    fun messagesArriveAsTheyWereGivenWithTheStampOfTheirCapture() = runBlocking<Unit> {
        val publisher = fixture.streamer.publisher("temperature", FLOAT)
        val session = fixture.start(CUSTOM)
        val channel = session.channels().getValue("custom/temperature")
        assertEquals(listOf("custom", "custom", FLOAT, "sensor", "", "sensors"), channel.texts(FIELDS))
        val captureNanos = fixture.now
        publisher.publishOnceOpen(1, captureNanos)
        assertTrue(publisher.publish(ByteBuffer.wrap(message(2)), captureNanos))
        val frames = session.awaitData("custom/temperature", 2)
        assertContentEquals(message(1), frames[0].body)
        assertContentEquals(message(2), frames[1].body)
        assertEquals(fixture.streamer.stampNanos(captureNanos), frames[1].captureNanos)
        assertEquals(Counters(2, 2, emptyMap()), fixture.finish(session)["custom/temperature"])
    }

    @Test
    fun oneThatComesLaterIsAnnouncedAtOnceAndWaitsForItsStart() = runBlocking<Unit> {
        val session = fixture.start(CUSTOM)
        val publisher = fixture.streamer.publisher("late", FLOAT)
        session.await(HostFrame.CHANNEL)
        assertFalse(publisher.publish(ByteBuffer.wrap(message(0)), fixture.now))
        session.start(1)
        publisher.publishOnceOpen(1, fixture.now)
        assertContentEquals(message(1), session.awaitData("custom/late")[0].body)
        fixture.finish(session)
    }

    @Test
    fun aStartThatWasSaidBeforeItsChannelArrivedDoesNotOpenIt() = runBlocking<Unit> {
        val early = fixture.streamer.publisher("early", FLOAT)
        val session = fixture.start(CUSTOM)
        early.publishOnceOpen(1, fixture.now)
        val late = fixture.streamer.publisher("late", FLOAT)
        session.await(HostFrame.CHANNEL, 1)
        session.write(HostFrame.START, """{"request": 1, "channels": 1}""")
        session.write(HostFrame.PING)
        session.await(HostFrame.PONG)
        assertFalse(late.publish(ByteBuffer.wrap(message(0)), fixture.now))
        session.start(1)
        late.publishOnceOpen(1, fixture.now)
        fixture.finish(session)
    }

    @Test
    fun noneIsAnnouncedToAReceiverThatDoesNotAskForThem() = runBlocking<Unit> {
        val publisher = fixture.streamer.publisher("temperature", FLOAT)
        val session = fixture.start("""{"battery": {}}""")
        assertFalse(publisher.publish(ByteBuffer.wrap(message(0)), fixture.now))
        assertEquals(setOf("battery"), session.channels().keys)
        assertContains(publisher.refusal.orEmpty(), "custom.enabled")
        assertContains(fixture.streamer.publisher("another", FLOAT).refusal.orEmpty(), "custom.enabled")
        session.configure(2, CUSTOM)
        assertEquals(null, publisher.refusal)
        session.start(2)
        publisher.publishOnceOpen(1, fixture.now)
        fixture.finish(session)
    }

    @Test
    fun whatIsNoLongerAskedForEndsAndMayBeginAgain() = runBlocking<Unit> {
        val publisher = fixture.streamer.publisher("temperature", FLOAT)
        val session = fixture.start(CUSTOM)
        publisher.publishOnceOpen(1, fixture.now)
        session.configure(2, "{}")
        session.await(HostFrame.CHANNEL_END)
        assertFalse(publisher.publish(ByteBuffer.wrap(message(0)), fixture.now))
        session.configure(3, CUSTOM)
        session.start(3)
        publisher.publishOnceOpen(2, fixture.now)
        assertContentEquals(message(2), session.awaitData("custom/temperature", 2)[1].body)
        fixture.finish(session)
    }

    @Test
    fun whatEndsBeforeItsStreamHasBegunEndsToo() = runTest {
        val streams = streamsOnOneThread()
        val publisher = streams.publisher("temperature", FLOAT, isLatched = false, isLarge = false, will = null)
        streams.configure(ASKED, framePrefix = "", adapts = false)
        streams.start(streams.channels().map { it.id }.toSet())
        yield() // The stream has its turn after this test
        assertTrue(publisher.publish(ByteBuffer.wrap(message(1)), captureNanos = 0))
        streams.configure(emptyMap(), framePrefix = "", adapts = false)
        assertFalse(publisher.publish(ByteBuffer.wrap(message(2)), captureNanos = 0))
    }

    @Test
    fun aStartThatIsUnderWayAtTheEndOpensNothing() = runTest {
        val streams = streamsOnOneThread()
        val publisher = streams.publisher("temperature", FLOAT, isLatched = false, isLarge = false, will = null)
        streams.configure(ASKED, framePrefix = "", adapts = false)
        val known = streams.channels().map { it.id }.toSet()
        streams.start(known)
        yield()
        assertTrue(publisher.publish(ByteBuffer.wrap(message(1)), captureNanos = 0))
        streams.start(known)
        streams.stopSources()
        testScheduler.advanceUntilIdle()
        assertFalse(publisher.publish(ByteBuffer.wrap(message(2)), captureNanos = 0))
    }

    /** The streams of a headset whose clock is known; one thread runs them and the test, in turns. */
    private fun TestScope.streamsOnOneThread(): ActiveStreams {
        val clock = HostClock { 0 }
        repeat(16) { clock.add(TimeExchange(0, 0, 0, 0)) }
        return ActiveStreams(fixture.headset, clock, backgroundScope, { StandardTestDispatcher(testScheduler) })
    }

    /** A lane that is not joined delays the end beyond the streamer's patience. */
    @Test
    fun nothingIsOpenAfterAStopThatDidNotEndTheSession() = runBlocking<Unit> {
        val publisher = fixture.streamer.publisher("temperature", FLOAT)
        fixture.streamer.start()
        val session = fixture.host.awaitHello()
        session.welcome(timeouts = """{"handshake_s": 60, "ping_s": 1, "dead_s": 60}""")
        session.configure(1, CUSTOM)
        session.start(1)
        publisher.publishOnceOpen(1, fixture.now)
        fixture.host.silentLanes += "depth"
        val joined = session.frames(HostFrame.JOIN).size
        session.write(
            HostFrame.CONFIGURE,
            """{"request": 2, "streams": {"custom": {}, "depth": {}}, "frame_prefix": ""}""",
        )
        session.await(HostFrame.JOIN, joined)
        fixture.streamer.stop()
        assertFalse(publisher.publish(ByteBuffer.wrap(message(2)), fixture.now))
    }

    @Test
    fun aTopicThatTheReceiverDoesNotPublishSaysWhyUntilTheNextSession() = runBlocking<Unit> {
        val publisher = fixture.streamer.publisher("thing", "my_msgs/msg/Thing")
        val session = fixture.start(CUSTOM)
        publisher.publishOnceOpen(1, fixture.now)
        val id = session.channels().getValue("custom/thing").getValue("id")
        session.write(
            HostFrame.ERROR,
            """{"code": "channel", "message": "no such type", "fatal": false, "channel": $id}""",
        )
        eventually { publisher.refusal == "no such type" }
        assertFalse(publisher.publish(ByteBuffer.wrap(message(0)), fixture.now))
        session.close()
        val next = fixture.session(CUSTOM)
        publisher.publishOnceOpen(2, fixture.now)
        assertEquals(null, publisher.refusal)
        fixture.finish(next)
    }

    @Test
    fun aCaptureInTheFutureIsRefusedAndCountedAndStopsNoStamps() = runBlocking<Unit> {
        val publisher = fixture.streamer.publisher("temperature", FLOAT)
        val session = fixture.start(CUSTOM)
        publisher.publishOnceOpen(1, fixture.now)
        val wallNanos = System.currentTimeMillis() * 1_000_000
        assertFalse(publisher.publish(ByteBuffer.wrap(message(2)), wallNanos))
        assertEquals(null, fixture.streamer.stampNanos(wallNanos))
        fixture.host.clockOffsetNanos += STEP_NANOS
        val offsetNanos = fixture.host.clockOffsetNanos + System.nanoTime() - fixture.now
        eventually {
            val now = fixture.now
            abs(checkNotNull(fixture.streamer.stampNanos(now)) - now - offsetNanos) < STEP_NANOS / 10
        }
        assertTrue(publisher.publish(ByteBuffer.wrap(message(3)), fixture.now))
        val counters = fixture.finish(session)["custom/temperature"]
        assertEquals(Counters(3, 2, mapOf("future_capture" to 1)), counters)
    }

    @Test
    fun theNumbersOfTopicsAreBounded() {
        val first = fixture.streamer.publisher("topic0", FLOAT)
        for (number in 1 until 32) fixture.streamer.publisher("topic$number", FLOAT)
        assertFailsWith<IllegalStateException> { fixture.streamer.publisher("topic32", FLOAT) }
        assertSame(first, fixture.streamer.publisher("topic0", FLOAT))
    }

    @Test
    fun whatRosForbidsIsRefusedAtOnce() {
        val streamer = fixture.streamer
        for (name in listOf("", "a/b", "_a", "a__b", "a_", "1a", "~a", "ä", "a".repeat(65))) {
            assertFailsWith<IllegalArgumentException>(name) { streamer.publisher(name, FLOAT) }
        }
        for (type in listOf("", "std_msgs/Float32", "std_msgs/srv/Trigger", "a/msg/b", "a/msg/A" + "b".repeat(122))) {
            assertFailsWith<IllegalArgumentException>(type) { streamer.publisher("a", type) }
        }
        val publisher = streamer.publisher("a", FLOAT)
        assertFailsWith<IllegalArgumentException> { streamer.publisher("a", "std_msgs/msg/Float64") }
        for (bytes in listOf(byteArrayOf(), byteArrayOf(0, 0, 0, 0, 1), message(0).copyOf(65537))) {
            assertFailsWith<IllegalArgumentException> { publisher.publish(ByteBuffer.wrap(bytes), 0) }
        }
    }

    @Test
    fun absoluteLatchedAndLargeTopicsAndWillsAreAnnouncedAsTheyWereMade() = runBlocking<Unit> {
        val will = Will(ByteBuffer.wrap(message(9)), 100.milliseconds)
        val command = fixture.streamer.publisher("/cmd_vel", FLOAT, will = will)
        fixture.streamer.publisher("mode", FLOAT, isLatched = true)
        val session = fixture.start(CUSTOM, ros = true)
        val channels = session.channels()
        assertEquals(
            listOf("custom", "custom", FLOAT, "sensor", "", "sensors"),
            channels.getValue("/cmd_vel").texts(FIELDS),
        )
        val said = channels.getValue("/cmd_vel").getValue("will").jsonObject
        assertEquals("""{"payload":"AAEAAAkAAAA=","silent_ms":100}""", said.toString())
        assertEquals("latched", channels.getValue("custom/mode").getValue("qos").jsonPrimitive.content)
        command.publishOnceOpen(1, fixture.now)
        assertContentEquals(message(1), session.awaitData("/cmd_vel")[0].body)
        // Joins a lane of its own while the session runs
        val map = fixture.streamer.publisher("map", FLOAT, isLarge = true)
        session.await(HostFrame.CHANNEL, 2)
        session.start(1)
        val large = message(0).copyOf(16 shl 20)
        eventually { map.publish(ByteBuffer.wrap(large), fixture.now) }
        val (frame) = session.awaitData("custom/map")
        assertEquals("custom", frame.lane)
        assertContentEquals(large, frame.body)
        assertFailsWith<IllegalArgumentException> { map.publish(ByteBuffer.wrap(large.copyOf(large.size + 1)), 0) }
        fixture.finish(session)
    }

    @Test
    fun aReceiverThatServesNoAppsIsToldOfPlainTopicsAlone() = runBlocking<Unit> {
        val plain = fixture.streamer.publisher("plain", FLOAT)
        val others = listOf(
            fixture.streamer.publisher("/cmd_vel", FLOAT),
            fixture.streamer.publisher("mode", FLOAT, isLatched = true),
            fixture.streamer.publisher("map", FLOAT, isLarge = true),
            fixture.streamer.publisher("stop", FLOAT, will = Will(ByteBuffer.wrap(message(9)), 50.milliseconds)),
        )
        val session = fixture.start(CUSTOM)
        plain.publishOnceOpen(1, fixture.now)
        assertEquals(setOf("custom/plain"), session.channels().keys)
        for (it in others) {
            assertFalse(it.publish(ByteBuffer.wrap(message(1)), fixture.now))
            assertContains(it.refusal.orEmpty(), "serves no apps")
        }
        session.close()
        val next = fixture.session(CUSTOM, ros = true)
        others.forEach { it.publishOnceOpen(1, fixture.now) }
        fixture.finish(next)
    }

    @Test
    fun aTopicKeepsWhatItWasMadeWithAndAWillHasBounds() {
        val streamer = fixture.streamer
        streamer.publisher("a", FLOAT)
        assertFailsWith<IllegalArgumentException> { streamer.publisher("a", FLOAT, isLatched = true) }
        assertFailsWith<IllegalArgumentException> { streamer.publisher("a", FLOAT, isLarge = true) }
        for (name in listOf("/", "/a/", "//a", "/a/_b", "/1a", "/a__b", "/" + "a".repeat(255))) {
            assertFailsWith<IllegalArgumentException>(name) { streamer.publisher(name, FLOAT) }
        }
        val word = ByteBuffer.wrap(message(1))
        for (silence in listOf(49.milliseconds, 5001.milliseconds, 100_500.microseconds)) {
            assertFailsWith<IllegalArgumentException>("$silence") { Will(word, silence) }
        }
        assertFailsWith<IllegalArgumentException> { Will(ByteBuffer.allocate(8), 1.seconds) }
        assertFailsWith<IllegalArgumentException> { Will(ByteBuffer.wrap(message(1).copyOf(2049)), 1.seconds) }
    }

    /** START travels on another connection than what tells the test of it. */
    private suspend fun TopicPublisher.publishOnceOpen(number: Int, captureNanos: Long) =
        eventually { publish(ByteBuffer.wrap(message(number)), captureNanos) }

    private suspend fun eventually(isSo: () -> Boolean) = withTimeout(TEST_LIMIT) {
        while (!isSo()) delay(1.milliseconds)
    }

    private fun JsonObject.texts(keys: List<String>) = keys.map { getValue(it).jsonPrimitive.content }

    private companion object {
        const val FLOAT = "std_msgs/msg/Float32"
        const val CUSTOM = """{"custom": {}}"""
        val ASKED = mapOf(StreamTable.custom.id to StreamTable.custom.defaultValues())

        /** Ahead, so that it is followed at once. */
        const val STEP_NANOS = 10_000_000_000L
        val FIELDS = listOf("stream", "role", "type", "qos", "frame_id", "lane")

        fun message(number: Int) = byteArrayOf(0, 1, 0, 0, number.toByte(), 0, 0, 0)
    }
}
