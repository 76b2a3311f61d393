package dev.ml2sensors.stream

import dev.ml2sensors.TEST_LIMIT
import dev.ml2sensors.session.HostFrame
import dev.ml2sensors.session.HostSession
import dev.ml2sensors.source.Answer
import dev.ml2sensors.source.VectorSample
import dev.ml2sensors.table.StreamTable
import kotlinx.coroutines.runBlocking
import kotlinx.serialization.json.JsonElement
import kotlinx.serialization.json.jsonObject
import org.junit.jupiter.api.AfterEach
import org.junit.jupiter.api.Test
import java.io.IOException
import kotlin.test.assertEquals
import kotlin.test.assertIs
import kotlin.test.assertTrue
import kotlin.time.TimeSource

/** A stream that the receiver asked for runs, or says why not, and comes back by itself. */
class OutageTest {
    private val fixture = StreamFixture()
    private val headset = fixture.headset

    @AfterEach
    fun close() = fixture.close()

    @Test
    fun aSourceThatFailsComesBackOnTheSameChannel() = runBlocking<Unit> {
        val session = fixture.start("""{"world_left": {}, "gyro_left": {}}""")
        headset.deliver(StreamTable.worldLeft, headset.image(fixture.now))
        headset.end(StreamTable.worldLeft, IOException("unplugged"))
        session.awaitState("world_left", """{"state":"waiting","reason":"IOException: unplugged"}""")
        headset.deliver(StreamTable.gyroLeft, VectorSample(fixture.now, 0.0, 0.0, 0.0))
        session.awaitData("gyro_left/imu")
        headset.deliver(StreamTable.worldLeft, headset.image(fixture.now))
        session.awaitState("world_left", """{"state":"running"}""")
        assertIs<StreamState.Running>(fixture.streamer.streams.value["world_left"])
        val images = session.awaitData("world_left/image_raw", 2)
        assertEquals(listOf(0L, 1L), images.map { it.sequence })
        assertEquals(emptyList(), session.frames(HostFrame.CHANNEL_END))
        assertEquals(Counters(2, 2, emptyMap()), fixture.finish(session)["world_left/image_raw"])
    }

    @Test
    fun whatWaitsWaitsOnWhileOthersAreConfigured() = runBlocking<Unit> {
        val session = fixture.start("""{"world_left": {}}""")
        headset.end(StreamTable.worldLeft, IOException("unplugged"))
        session.awaitState("world_left", """{"state":"waiting","reason":"IOException: unplugged"}""")
        session.configure(2, """{"world_left": {}, "gyro_left": {}}""")
        assertEquals(StreamState.Waiting("IOException: unplugged"), fixture.streamer.streams.value["world_left"])
        session.start(2)
        headset.deliver(StreamTable.worldLeft, headset.image(fixture.now))
        session.awaitData("world_left/image_raw")
    }

    @Test
    fun otherValuesAreTriedAtOnceAndTheStreamWaitsUntilItDelivers() = runBlocking<Unit> {
        val session = fixture.start("""{"depth": {"update_rate": 5}}""")
        headset.end(StreamTable.depth, IOException("unplugged"))
        session.awaitState("depth", """{"state":"waiting","reason":"IOException: unplugged"}""")
        session.configure(2, """{"depth": {"update_rate": 30}}""")
        assertEquals(StreamState.Waiting("IOException: unplugged"), fixture.streamer.streams.value["depth"])
        session.start(2)
        headset.deliver(StreamTable.depth, headset.image(fixture.now))
        session.awaitData("depth/image_raw")
        session.awaitState("depth", """{"state":"running"}""")
        assertIs<StreamState.Running>(fixture.streamer.streams.value["depth"])
    }

    @Test
    fun aStreamThatIsNoLongerRequestedHasNoStateThatItKeeps() = runBlocking<Unit> {
        val session = fixture.start("""{"depth": {}}""")
        headset.end(StreamTable.depth, IOException("unplugged"))
        session.awaitState("depth", """{"state":"waiting","reason":"IOException: unplugged"}""")
        session.configure(2, "{}")
        session.configure(3, """{"depth": {}}""")
        assertIs<StreamState.Running>(fixture.streamer.streams.value["depth"])
    }

    @Test
    fun whatWasRefusedIsToldToBeAvailableAsSoonAsItIs() = runBlocking<Unit> {
        headset.answers[StreamTable.depth] = Answer.Refused("not granted", "a.permission")
        val session = fixture.start("""{"depth": {}, "battery": {}}""")
        session.awaitState("depth", """{"state":"refused","reason":"not granted","permission":"a.permission"}""")
        headset.answers -= StreamTable.depth
        session.awaitState("depth", """{"state":"available","reason":"not granted","permission":"a.permission"}""")
        session.configure(2, """{"depth": {}, "battery": {}}""")
        session.start(2)
        headset.deliver(StreamTable.depth, headset.image(fixture.now))
        session.awaitData("depth/image_raw")
    }

    @Test
    fun whatIsHeldBackSaysWhy() = runBlocking<Unit> {
        headset.holds = mapOf("head_pose" to "drawing")
        val session = fixture.start("""{"tf": {}, "battery": {}}""")
        session.awaitState("tf", """{"state":"waiting","reason":"drawing"}""")
        session.awaitState("battery", """{"state":"running"}""")
    }

    private fun HostSession.awaitState(stream: String, state: String) {
        val end = TimeSource.Monotonic.markNow() + TEST_LIMIT
        var seen = 0
        var found: JsonElement? = null
        while (found.toString() != state) {
            assertTrue(end.hasNotPassedNow(), "the last state of $stream is $found, expected $state")
            found = await(HostFrame.STATUS, seen++).json["streams"]?.jsonObject?.get(stream)
        }
    }
}
