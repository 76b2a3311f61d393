package dev.ml2sensors.stream

import dev.ml2sensors.session.HostSession
import dev.ml2sensors.source.Sample
import dev.ml2sensors.source.VectorSample
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable
import kotlinx.coroutines.CoroutineScope
import kotlinx.coroutines.Dispatchers
import kotlinx.coroutines.cancelAndJoin
import kotlinx.coroutines.delay
import kotlinx.coroutines.launch
import kotlinx.coroutines.runBlocking
import kotlinx.serialization.json.int
import kotlinx.serialization.json.jsonObject
import kotlinx.serialization.json.jsonPrimitive
import org.junit.jupiter.api.AfterEach
import org.junit.jupiter.api.Test
import kotlin.test.assertContains
import kotlin.test.assertEquals
import kotlin.test.assertTrue

/** produced = received + gaps, and gaps = sum of drops by reason, whatever the link does. */
class CountersTest {
    private val fixture = StreamFixture(receiveBufferBytes = 16_384)
    private val headset = fixture.headset

    @AfterEach
    fun close() = fixture.close()

    @Test
    fun aSlowHostLosesImagesToTheQueueAndNothingElse() = runBlocking<Unit> {
        val session = fixture.start("""{"world_left": {}, "gyro_left": {}}""", held = listOf("world_left"))
        val images = 40
        repeat(images) {
            val image = headset.image(fixture.now, it.toLong(), rowBytes = 256, height = 256, intrinsics = LENS)
            headset.deliver(StreamTable.worldLeft, image)
            headset.deliver(StreamTable.gyroLeft, VectorSample(fixture.now, 0.0, 0.0, 0.0))
        }
        assertEquals(emptyList(), session.data("world_left/image_raw"))
        session.release("world_left")
        generateSequence(1) { it + 1 }.map { session.awaitData("world_left/image_raw", it).last() }
            .first { it.sequence == images - 1L }
        val counters = fixture.finish(session)
        assertBalanced(listOf(session), counters)
        val image = counters.getValue("world_left/image_raw")
        assertEquals(setOf("queue_full"), image.dropped.keys)
        assertEquals(images.toLong(), image.produced)
        for (topic in counters.keys - "world_left/image_raw") {
            assertEquals(Counters(images.toLong(), images.toLong(), emptyMap()), counters[topic], topic)
        }
        val last = session.data("world_left/image_raw").takeLast(4).map { it.sequence }
        assertEquals(listOf(36L, 37, 38, 39), last, "the oldest go, the latest arrive")
    }

    @Test
    fun aLinkThatIsCutAgainAndAgainLosesWhatTheBooksSay() = runBlocking<Unit> {
        val sessions = mutableListOf(fixture.start(STREAMS))
        val sources = listOf(
            source(StreamTable.gyroLeft) { VectorSample(fixture.now, 0.0, 0.0, 0.0) },
            source(StreamTable.worldLeft) { headset.image(fixture.now, rowBytes = 128, height = 128) },
            source(StreamTable.depth) { headset.image(fixture.now, rowBytes = 256, height = 256) },
        )
        repeat(4) {
            sessions.last().awaitData("gyro_left/imu", 20)
            sessions.last().awaitData("depth/image_raw", 5)
            sessions.last().cut()
            sessions += fixture.session(STREAMS)
        }
        sessions.last().awaitData("gyro_left/imu", 20)
        sources.forEach { it.cancelAndJoin() }
        val counters = fixture.finish(sessions.last())
        assertBalanced(sessions, counters)
        assertContains(counters.getValue("gyro_left/imu").dropped, "link_down")
        val numbers = sessions.flatMap { session -> session.data("gyro_left/imu").map { it.sequence } }
        assertEquals(numbers.sorted().distinct(), numbers, "numbers go on across sessions")
    }

    @Test
    fun anInstanceTheReceiverDoesNotKnowKeepsItsBooks() = runBlocking<Unit> {
        val first = fixture.start("""{"battery": {}, "gyro_left": {}}""")
        repeat(5) { headset.deliver(StreamTable.gyroLeft, VectorSample(fixture.now, 0.0, 0.0, 0.0)) }
        first.awaitData("gyro_left/imu", 5)
        first.cut()
        val second = fixture.host.awaitHello()
        val before = second.hello.json.getValue("channels").jsonObject.getValue("gyro_left/imu").jsonObject
        assertEquals(5, before.getValue("produced").jsonPrimitive.int)
        val sent = before.getValue("sent").jsonPrimitive.int
        assertTrue(sent >= 4, "all but what may have been under way count as sent: $before")
        second.welcome(received = null)
        second.configure(1, """{"gyro_left": {}}""")
        second.start(1)
        val counts = fixture.finish(second).getValue("gyro_left/imu")
        assertEquals(5, counts.sent + counts.dropped.values.sum())
        assertTrue(counts.sent >= sent, "what counts as sent stays so: $counts")
    }

    /** A sensor that delivers about every millisecond. */
    private fun CoroutineScope.source(stream: StreamSpec, sample: () -> Sample) =
        launch(Dispatchers.Default) {
            while (true) {
                headset.deliver(stream, sample())
                delay(1)
            }
        }

    private fun assertBalanced(sessions: List<HostSession>, counters: Map<String, Counters>) {
        for ((topic, counts) in counters) {
            val numbers = sessions.flatMap { session -> session.data(topic).map { it.sequence } }
            val gaps = counts.produced - numbers.size
            assertEquals(numbers.size.toLong(), counts.sent, "$topic: $counts")
            assertEquals(gaps, counts.dropped.values.sum(), "$topic: $counts")
            assertTrue(numbers.all { it in 0 until counts.produced }, topic)
        }
    }

    private companion object {
        const val STREAMS = """{"world_left": {}, "depth": {}, "gyro_left": {}, "tf": {}}"""
        val LENS = CameraFixtures.pinhole(256, 256)
    }
}
