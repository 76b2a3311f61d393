package dev.ml2sensors.stream

import dev.ml2sensors.TEST_LIMIT
import dev.ml2sensors.clock.HostClock
import dev.ml2sensors.clock.TimeExchange
import dev.ml2sensors.session.HostSession
import dev.ml2sensors.session.ScriptedHost
import dev.ml2sensors.source.Answer
import dev.ml2sensors.source.BatterySample
import dev.ml2sensors.source.ChargeStatus
import dev.ml2sensors.source.Headset
import dev.ml2sensors.source.Sample
import dev.ml2sensors.source.SourceException
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.source.VectorSample
import dev.ml2sensors.source.defaultValues
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable
import dev.ml2sensors.transport.TransportSecurity
import kotlinx.coroutines.CoroutineScope
import kotlinx.coroutines.Dispatchers
import kotlinx.coroutines.Job
import kotlinx.coroutines.NonCancellable
import kotlinx.coroutines.async
import kotlinx.coroutines.cancel
import kotlinx.coroutines.flow.Flow
import kotlinx.coroutines.flow.emitAll
import kotlinx.coroutines.flow.first
import kotlinx.coroutines.flow.flow
import kotlinx.coroutines.launch
import kotlinx.coroutines.runBlocking
import kotlinx.coroutines.test.StandardTestDispatcher
import kotlinx.coroutines.test.TestCoroutineScheduler
import kotlinx.coroutines.withContext
import kotlinx.coroutines.withTimeout
import kotlinx.coroutines.yield
import org.junit.jupiter.api.AfterEach
import org.junit.jupiter.api.Test
import java.util.concurrent.ConcurrentHashMap
import java.util.concurrent.CountDownLatch
import kotlin.test.assertEquals
import kotlin.test.assertIs
import kotlin.test.assertTrue

/** A headset whose calls do not return until the test says so. */
class NeverAnswersTest {
    private val host = ScriptedHost()
    private val fake = FakeHeadset()
    private val answer = CountDownLatch(1)
    private val asking: MutableSet<StreamSpec> = ConcurrentHashMap.newKeySet()
    private val closing: MutableSet<StreamSpec> = ConcurrentHashMap.newKeySet()
    private val opening: MutableSet<StreamSpec> = ConcurrentHashMap.newKeySet()
    private val headset = object : Headset by fake {
        override fun negotiate(stream: StreamSpec, requested: StreamValues): Answer {
            if (stream in asking) answer.await()
            return fake.negotiate(stream, requested)
        }

        override fun samples(stream: StreamSpec, values: StreamValues): Flow<Sample> = flow {
            if (stream in opening) answer.await()
            try {
                emitAll(fake.samples(stream, values))
            } finally {
                if (stream in closing) withContext(NonCancellable + Dispatchers.IO) { answer.await() }
            }
        }
    }
    private val streamer = Ml2Streamer(headset, host.address, TransportSecurity.Insecure(allowsEyeImages = true))

    @AfterEach
    fun close() {
        answer.countDown()
        runBlocking { streamer.stop() }
        host.close()
    }

    private suspend fun sessionWithAStreamThatDoesNotClose(): HostSession {
        closing += StreamTable.worldLeft
        streamer.start()
        return host.session("""{"world_left": {}, "gyro_left": {}}""").also { fake.awaitRunning(StreamTable.worldLeft) }
    }

    private suspend fun await(id: String, isSo: (StreamState?) -> Boolean) =
        withTimeout(TEST_LIMIT) { streamer.streams.first { isSo(it[id]) } }

    @Test
    fun aStreamThatDoesNotStopIsLostAloneAndSaysSoAndComesBack() = runBlocking<Unit> {
        val session = sessionWithAStreamThatDoesNotClose()
        val gyroscope = launch(Dispatchers.Default) {
            for (count in 1..Int.MAX_VALUE) {
                fake.deliver(StreamTable.gyroLeft, VectorSample(fake.clock.nowNanos(), 0.0, 0.0, 0.0))
                session.awaitData("gyro_left/imu", count)
            }
        }
        session.configure(2, """{"gyro_left": {}, "battery": {}}""")
        session.start(2)
        fake.deliver(StreamTable.battery, BatterySample(fake.clock.nowNanos(), 4f, 1f, 0.5f, ChargeStatus.DISCHARGING))
        session.awaitData("battery")
        session.configure(3, """{"gyro_left": {}, "battery": {}, "world_left": {}}""")
        session.start(3)
        await("world_left") { it is StreamState.Waiting && "has not let go" in it.reason }
        session.awaitData("gyro_left/imu", session.data("gyro_left/imu").size + 20)
        answer.countDown()
        fake.awaitRunning(StreamTable.worldLeft)
        fake.deliver(StreamTable.worldLeft, fake.image(fake.clock.nowNanos()))
        await("world_left") { it is StreamState.Running }
        gyroscope.cancel()
    }

    /** Time stands still, so that the stream is awaited until another has changed its state. */
    @Test
    fun noLockIsHeldWhileAStreamThatDoesNotStopIsAwaited() = runBlocking<Unit> {
        closing += StreamTable.worldLeft
        val values = listOf(StreamTable.worldLeft, StreamTable.gyroLeft).associate { it.id to it.defaultValues() }
        val scope = CoroutineScope(Dispatchers.Default + Job())
        val clock = HostClock(fake.clock)
        repeat(16) { fake.clock.nowNanos().let { clock.add(TimeExchange(it, it, it, it)) } }
        val streams = ActiveStreams(headset, clock, scope)
        streams.configure(values, framePrefix = "", adapts = false)
        streams.start(emptySet())
        fake.awaitRunning(StreamTable.worldLeft)
        val time = TestCoroutineScheduler()
        val gyroscope = values - StreamTable.worldLeft.id
        val configuring =
            scope.launch(StandardTestDispatcher(time)) { streams.configure(gyroscope, "", adapts = false) }
        val isWaiting = scope.async {
            fake.awaitStopped(StreamTable.worldLeft)
            fake.end(StreamTable.gyroLeft, SourceException("broken"))
            streams.states.first { it[StreamTable.gyroLeft.id] is StreamState.Waiting }
        }
        withTimeout(TEST_LIMIT) {
            while (!isWaiting.isCompleted) {
                time.runCurrent()
                yield()
            }
        }
        assertTrue(configuring.isActive)
        answer.countDown()
        while (!configuring.isCompleted) {
            time.runCurrent()
            yield()
        }
        streams.stopSources()
        scope.cancel()
    }

    @Test
    fun theNextSessionIsConfiguredToo() = runBlocking<Unit> {
        val first = sessionWithAStreamThatDoesNotClose()
        first.configure(2, "{}")
        first.close()
        host.session("""{"gyro_left": {}}""")
        fake.awaitRunning(StreamTable.gyroLeft)
    }

    @Test
    fun questionsWithoutAnAnswerRefuseTheirStreamsAlone() = runBlocking<Unit> {
        asking += listOf(StreamTable.color, StreamTable.depth)
        streamer.start()
        val hello = host.awaitHello()
        assertTrue("\"color\"" !in hello.hello.json.getValue("capabilities").toString())
        hello.welcome()
        val answers = hello.configure(1, """{"color": {}, "depth": {}, "gyro_left": {}}""")
        assertTrue("no answer within" in answers.getValue("color").toString(), "$answers")
        assertEquals("""{"result":"applied","values":{}}""", answers.getValue("gyro_left").toString())
        hello.start(1)
        fake.awaitRunning(StreamTable.gyroLeft)
    }

    @Test
    fun aThreadThatASourceBlocksIsNotThatOfOthers() = runBlocking<Unit> {
        opening += StreamTable.all.filter { it != StreamTable.gyroLeft && it != StreamTable.custom }
        streamer.start()
        val all = opening.joinToString { "\"${it.id}\": {}" }
        host.session("""{$all, "gyro_left": {}}""")
        fake.deliver(StreamTable.gyroLeft, VectorSample(fake.clock.nowNanos(), 0.0, 0.0, 0.0))
        await("depth") { it is StreamState.Waiting && "no capture for" in it.reason }
        val state = withTimeout(TEST_LIMIT) {
            streamer.stop("over")
            streamer.state.first { it is StreamerState.Ended }
        }
        assertEquals("over", assertIs<StreamerState.Ended>(state).reason)
    }
}
