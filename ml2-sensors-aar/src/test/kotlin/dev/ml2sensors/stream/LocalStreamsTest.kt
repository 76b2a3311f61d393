package dev.ml2sensors.stream

import dev.ml2sensors.TEST_LIMIT
import dev.ml2sensors.session.ReceiverAddress
import dev.ml2sensors.session.ScriptedHost
import dev.ml2sensors.source.Answer
import dev.ml2sensors.source.Headset
import dev.ml2sensors.source.Sample
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.source.defaultValues
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable
import dev.ml2sensors.transport.TransportSecurity
import kotlinx.coroutines.flow.Flow
import kotlinx.coroutines.flow.first
import kotlinx.coroutines.flow.flow
import kotlinx.coroutines.runBlocking
import kotlinx.coroutines.withTimeout
import kotlinx.coroutines.withTimeoutOrNull
import org.junit.jupiter.api.Test
import java.io.IOException
import kotlin.test.assertEquals
import kotlin.test.assertFalse
import kotlin.test.assertIs
import kotlin.test.assertTrue
import kotlin.time.Duration.Companion.milliseconds

/** Tests the streams that run on the headset while no receiver answers. */
class LocalStreamsTest {
    private val headset = FakeHeadset()

    /** Nobody listens there. */
    private val nowhere = ReceiverAddress("no-such-host.invalid", 1)

    @Test
    fun framesAreDeliveredThoughNobodyListens() = withStreamer("world_left") { streamer ->
        assertTrue(headset.deliver(StreamTable.worldLeft, headset.image(1)))
        val states = withTimeout(TEST_LIMIT) { streamer.streams.first { it.isNotEmpty() } }
        val state = assertIs<StreamState.Running>(states["world_left"])
        assertEquals(StreamTable.worldLeft.defaultValues(), state.values)
        streamer.stop()
        assertFalse(headset.isRunning(StreamTable.worldLeft))
        assertEquals(0, headset.pool.outstanding)
    }

    @Test
    fun whatAStreamDoesNotSayIsItsFirstMode() = withStreamer(
        mapOf("world_left" to StreamValues(stream = 1, quality = 60), "gyro_left" to StreamValues()),
    ) { streamer ->
        assertTrue(headset.deliver(StreamTable.worldLeft, headset.image(1)))
        val both = withTimeout(TEST_LIMIT) { streamer.streams.first { it.size == 2 } }
        val states = both.mapValues { assertIs<StreamState.Running>(it.value).values }
        assertEquals(StreamValues(1, 1016, 1016, 30, "Grayscale", quality = 60), states["world_left"])
        assertEquals(StreamValues(), states["gyro_left"])
    }

    @Test
    fun whatCannotRunSaysWhy() {
        headset.answers[StreamTable.depth] = Answer.Refused("no depth here", "a.permission")
        withStreamer("depth", "no_stream") { streamer ->
            val states = withTimeout(TEST_LIMIT) { streamer.streams.first { it.isNotEmpty() } }
            assertEquals(StreamState.Refused("no depth here", "a.permission"), states["depth"])
            assertIs<StreamState.Refused>(states["no_stream"])
        }
    }

    @Test
    fun aSourceThatFailsIsToldAndTheOthersGoOn() = withStreamer("world_left", "world_right") { streamer ->
        headset.end(StreamTable.worldLeft, IOException("unplugged"))
        val states = withTimeout(TEST_LIMIT) {
            streamer.streams.first { it["world_left"] is StreamState.Waiting }
        }
        assertEquals(StreamState.Waiting("IOException: unplugged"), states["world_left"])
        assertTrue(headset.deliver(StreamTable.worldRight, headset.image(1)))
        assertTrue(headset.deliver(StreamTable.worldLeft, headset.image(2)), "it comes back")
        assertIs<StreamState.Running>(streamer.streams.value["world_left"])
    }

    @Test
    fun whatIsAllowedLaterRunsThen() {
        headset.answers[StreamTable.depth] = Answer.Refused("no depth here", "a.permission")
        withStreamer("depth") { streamer ->
            withTimeout(TEST_LIMIT) { streamer.streams.first { it["depth"] is StreamState.Refused } }
            headset.answers -= StreamTable.depth
            assertTrue(headset.deliver(StreamTable.depth, headset.image(1)))
            assertIs<StreamState.Running>(streamer.streams.value["depth"])
        }
    }

    @Test
    fun aSourceThatFailsBeforeTheNextBeginsIsTold() = runBlocking<Unit> {
        lateinit var streamer: Ml2Streamer
        suspend fun failure() = streamer.streams.first { it["world_left"] is StreamState.Waiting }
        val unplugged = object : Headset by headset {
            override fun negotiate(stream: StreamSpec, requested: StreamValues): Answer {
                if (stream == StreamTable.worldRight) runBlocking { withTimeoutOrNull(500.milliseconds) { failure() } }
                return headset.negotiate(stream, requested)
            }

            override fun samples(stream: StreamSpec, values: StreamValues): Flow<Sample> = when (stream) {
                StreamTable.worldLeft -> flow { throw IOException("unplugged") }
                else -> headset.samples(stream, values)
            }
        }
        val wanted = listOf("world_left", "world_right").associateWith { StreamValues() }
        streamer = Ml2Streamer(unplugged, nowhere, TransportSecurity.Insecure(), wanted)
        streamer.start()
        headset.deliver(StreamTable.worldRight, headset.image(1))
        withTimeout(TEST_LIMIT) { failure() }
        streamer.stop()
    }

    @Test
    fun whatAReceiverWantsReplacesThem() = runBlocking<Unit> {
        ScriptedHost().use { host ->
            val defaults = mapOf("world_left" to StreamValues())
            val streamer = Ml2Streamer(headset, host.address, TransportSecurity.Insecure(), defaults)
            streamer.start()
            host.awaitHello().close()
            assertTrue(headset.deliver(StreamTable.worldLeft, headset.image(1)))
            val session = host.awaitHello()
            session.welcome(host.received())
            session.configure(1, """{"world_right": {}}""")
            headset.awaitStopped(StreamTable.worldLeft)
            session.start(1)
            assertEquals(setOf("world_right"), streamer.streams.value.keys)
            headset.deliver(StreamTable.worldRight, headset.image(now()))
            session.awaitData("world_right/image_raw")
            session.cut()
            assertTrue(headset.deliver(StreamTable.worldRight, headset.image(now())))
            assertFalse(headset.isRunning(StreamTable.worldLeft), "what the receiver wanted goes on without it")
            streamer.stop()
        }
    }

    private fun now() = headset.clock.nowNanos()

    private fun withStreamer(vararg ids: String, test: suspend (Ml2Streamer) -> Unit) =
        withStreamer(ids.associateWith { StreamValues() }, test)

    private fun withStreamer(
        wanted: Map<String, StreamValues>,
        test: suspend (Ml2Streamer) -> Unit,
    ) = runBlocking<Unit> {
        val streamer = Ml2Streamer(headset, nowhere, TransportSecurity.Insecure(), wanted)
        try {
            streamer.start()
            test(streamer)
        } finally {
            streamer.stop()
        }
    }
}
