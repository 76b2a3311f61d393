package dev.ml2sensors.stream

import dev.ml2sensors.TEST_LIMIT
import dev.ml2sensors.cdr.Cdr
import dev.ml2sensors.message.StringMessage
import dev.ml2sensors.ros.Received
import dev.ml2sensors.session.HostFrame
import dev.ml2sensors.session.ReceiverAddress
import dev.ml2sensors.source.URGENT_PRIORITY
import dev.ml2sensors.source.VectorSample
import dev.ml2sensors.table.StreamTable
import dev.ml2sensors.test
import dev.ml2sensors.transport.TransportSecurity
import kotlinx.coroutines.Dispatchers
import kotlinx.coroutines.async
import kotlinx.coroutines.cancelAndJoin
import kotlinx.coroutines.delay
import kotlinx.coroutines.flow.first
import kotlinx.coroutines.launch
import kotlinx.coroutines.runBlocking
import kotlinx.coroutines.withTimeout
import kotlinx.serialization.json.jsonObject
import kotlinx.serialization.json.jsonPrimitive
import org.junit.jupiter.api.AfterEach
import org.junit.jupiter.api.Test
import java.util.concurrent.ConcurrentLinkedQueue
import kotlin.test.assertEquals
import kotlin.test.assertFailsWith
import kotlin.test.assertIs
import kotlin.test.assertTrue
import kotlin.time.Duration.Companion.hours
import kotlin.time.Duration.Companion.milliseconds
import kotlin.time.Duration.Companion.minutes
import kotlin.time.Duration.Companion.seconds
import kotlin.time.TimeSource

class Ml2StreamerTest {
    private val fixture = StreamFixture()

    @AfterEach
    fun close() = fixture.close()

    @Test
    fun theStateSaysWhereTheStreamerIs() = runBlocking<Unit> {
        fixture.streamer.state.test {
            assertEquals(StreamerState.Connecting(null), awaitItem())
            val session = fixture.start("{}")
            assertEquals(StreamerState.Connected("scripted"), awaitItem())
            fixture.streamer.stop("enough")
            assertEquals("""{"reason":"enough"}""", session.await(HostFrame.BYE).body.decodeToString())
            assertEquals(StreamerState.Ended("enough"), awaitItem())
        }
    }

    @Test
    fun threadsOfImagesGiveWay() = runBlocking<Unit> {
        fixture.start("""{"gyro_left": {}, "accel_left": {}, "world_left": {}, "depth": {}}""")
        for (stream in listOf(StreamTable.gyroLeft, StreamTable.accelLeft)) {
            assertEquals(URGENT_PRIORITY, fixture.headset.awaitPriority(stream), stream.id)
        }
        for (stream in listOf(StreamTable.worldLeft, StreamTable.depth)) {
            assertEquals(Thread.NORM_PRIORITY, fixture.headset.awaitPriority(stream), stream.id)
        }
    }

    @Test
    fun aBusyReceiverIsTriedAgain() = runBlocking<Unit> {
        fixture.streamer.state.test {
            assertEquals(StreamerState.Connecting(null), awaitItem())
            fixture.streamer.start()
            repeat(2) {
                val error = """{"code": "busy", "message": "another is connected", "fatal": true}"""
                fixture.host.awaitHello().write(HostFrame.ERROR, error)
            }
            val reason = assertIs<StreamerState.Connecting>(awaitItem()).reason
            assertEquals("the receiver says busy: another is connected", reason)
            fixture.session("{}")
            assertEquals(StreamerState.Connected("scripted"), awaitItem())
        }
    }

    @Test
    fun aReceiverThatLeavesIsFoundAgainByTheSameInstance() = runBlocking<Unit> {
        val first = fixture.start("""{"gyro_left": {}}""")
        fixture.headset.deliver(StreamTable.gyroLeft, VectorSample(fixture.now, 0.0, 0.0, 0.0))
        first.awaitData("gyro_left/imu")
        first.close()
        val second = fixture.session("""{"gyro_left": {}}""")
        val instances = listOf(first, second).map { it.hello.json.getValue("instance_id").jsonPrimitive.content }
        assertEquals(1, instances.distinct().size)
        val gyroscope = launch {
            while (true) {
                fixture.headset.deliver(StreamTable.gyroLeft, VectorSample(fixture.now, 0.0, 0.0, 0.0))
                delay(1)
            }
        }
        val arrived = async(Dispatchers.IO) { second.awaitData("gyro_left/imu")[0] }
        assertTrue(arrived.await().sequence >= 1)
        gyroscope.cancelAndJoin()
        fixture.finish(second)
    }

    @Test
    fun aSubscriptionOutlivesSessionsAndEndsWithTheStreamer() = runBlocking<Unit> {
        val message = StringMessage("hello")
        fixture.streamer.subscribe("/chatter", StringMessage.serializer()).test {
            fixture.streamer.start()
            repeat(2) { number ->
                val session = fixture.host.awaitHello()
                assertEquals("true", session.hello.json.getValue("capabilities").jsonObject["ros"].toString())
                session.welcome(fixture.host.received(), ros = true)
                session.await(HostFrame.OPEN)
                session.message(1, number, Cdr.encodeToByteArray(StringMessage.serializer(), message))
                assertEquals(Received(message, null, number.toLong()), awaitItem())
                session.cut()
            }
            fixture.streamer.stop()
            awaitComplete()
        }
    }

    @Test
    fun aHeadsetThatThrowsIsSaidAndTriedAgain() = runBlocking<Unit> {
        fixture.headset.readPermissions = { error("the package manager has died") }
        fixture.streamer.start()
        val state = withTimeout(TEST_LIMIT) {
            fixture.streamer.state.first { it != StreamerState.Connecting(null) }
        }
        assertEquals(StreamerState.Connecting("IllegalStateException: the package manager has died"), state)
        fixture.headset.readPermissions = ::emptyMap
        fixture.finish(fixture.session("{}"))
    }

    @Test
    fun anErrorEndsTheStreamerAndNotTheApp() = runBlocking<Unit> {
        fixture.headset.readPermissions = { throw NoClassDefFoundError("android/Missing") }
        val uncaught = ConcurrentLinkedQueue<Throwable>()
        val before = Thread.getDefaultUncaughtExceptionHandler()
        Thread.setDefaultUncaughtExceptionHandler { _, error -> uncaught += error }
        try {
            fixture.streamer.start()
            val state = withTimeout(TEST_LIMIT) { fixture.streamer.state.first { it is StreamerState.Ended } }
            assertEquals(StreamerState.Ended("failed: NoClassDefFoundError: android/Missing"), state)
        } finally {
            Thread.setDefaultUncaughtExceptionHandler(before)
        }
        assertEquals(emptyList(), uncaught.toList())
    }

    @Test
    fun aReceiverWithoutAnAddressIsWaitedFor() = runBlocking<Unit> {
        val streamer =
            Ml2Streamer(fixture.headset, ReceiverAddress("no-such-host.invalid", 1), TransportSecurity.Insecure())
        streamer.start()
        val state = withTimeout(TEST_LIMIT) {
            streamer.state.first { it is StreamerState.Connecting && it.reason != null }
        }
        assertTrue("no-such-host.invalid" in "$state")
        streamer.stop()
        assertEquals(StreamerState.Ended("stopped"), streamer.state.value)
    }

    @Test
    fun aSuspendOfTheDeviceIsAnEvent() = runBlocking<Unit> {
        val session = fixture.start("{}")
        fixture.headset.suspendedNanos += (8.hours + 2.minutes + 300.milliseconds).inWholeNanoseconds
        val event = session.await(HostFrame.EVENT).json
        assertEquals("suspended", event.getValue("event").jsonPrimitive.content)
        assertEquals("the headset slept for 8h 2m", event.getValue("text").jsonPrimitive.content)
    }

    @Test
    fun aStreamThatIsHeldWaitsInTheStatusOfTheApp() = runBlocking<Unit> {
        fixture.start("""{"gyro_left": {}}""")
        assertEquals("running", fixture.streamer.status().streams.getValue("gyro_left").state)
        fixture.headset.holds = mapOf("gyro_left" to "paused")
        val held = fixture.streamer.status().streams.getValue("gyro_left")
        assertEquals("waiting" to "paused", held.state to held.reason)
    }

    @Test
    fun aStreamerIsStartedOnce() {
        fixture.streamer.start()
        assertFailsWith<IllegalStateException> { fixture.streamer.start() }
    }

    @Test
    fun stoppingWithoutAReceiverReleasesWhatIsBorrowed() = runBlocking<Unit> {
        val session = fixture.start("""{"world_left": {}}""")
        fixture.headset.deliver(StreamTable.worldLeft, fixture.headset.image(fixture.now))
        session.cut()
        fixture.host.close()
        repeat(3) { fixture.headset.deliver(StreamTable.worldLeft, fixture.headset.image(fixture.now)) }
        fixture.streamer.stop()
        assertEquals(0, fixture.headset.pool.outstanding)
    }

    @Test
    fun aStopIsNotDelayedByAReceiverThatSaysNothing() = runBlocking<Unit> {
        fixture.streamer.start()
        val session = fixture.host.awaitHello()
        fixture.streamer.stop()
        session.awaitEnds()
        assertEquals(emptyList(), session.frames(HostFrame.ERROR), "the handshake's patience would end in one")
        assertEquals(StreamerState.Ended("stopped"), fixture.streamer.state.value)
    }

    /** Pauses of 50, 100, 200, 400 and 800 ms, then 1 s: eight sessions need 3.5 s. */
    @Test
    fun aReceiverThatBreaksEverySessionIsTriedLessAndLessOften() = runBlocking<Unit> {
        fixture.streamer.start()
        val began = TimeSource.Monotonic.markNow()
        repeat(8) {
            val session = fixture.host.awaitHello()
            session.welcome(fixture.host.received())
            session.write(HostFrame.CONFIGURE, "[]")
            session.awaitEnds()
        }
        assertTrue(began.elapsedNow() > 3.seconds, "took ${began.elapsedNow()}")
    }

    @Test
    fun aStopBeforeTheStartIsAnEndToo() = runBlocking<Unit> {
        val streamer = Ml2Streamer(fixture.headset, fixture.host.address, TransportSecurity.Insecure())
        streamer.stop("never mind")
        assertEquals(StreamerState.Ended("never mind"), streamer.state.value)
    }

    @Test
    fun aLongReasonIsCutToFitItsFrame() = runBlocking<Unit> {
        val session = fixture.start("{}")
        fixture.streamer.stop("x".repeat(10_000))
        assertTrue(session.await(HostFrame.BYE).body.size <= 4096)
    }
}
