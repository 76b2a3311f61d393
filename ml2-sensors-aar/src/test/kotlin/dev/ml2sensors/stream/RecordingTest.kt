package dev.ml2sensors.stream

import dev.ml2sensors.message.Transform
import dev.ml2sensors.session.HostFrame
import dev.ml2sensors.source.BatterySample
import dev.ml2sensors.source.ChargeStatus
import dev.ml2sensors.source.Headset
import dev.ml2sensors.source.PoseSample
import dev.ml2sensors.source.VectorSample
import dev.ml2sensors.table.StreamTable
import dev.ml2sensors.test
import kotlinx.coroutines.CoroutineStart
import kotlinx.coroutines.Dispatchers
import kotlinx.coroutines.launch
import kotlinx.coroutines.runBlocking
import org.junit.jupiter.api.AfterEach
import org.junit.jupiter.api.Test
import java.io.IOException
import kotlin.test.assertEquals
import kotlin.test.assertFalse
import kotlin.test.assertTrue

/** A recording waits for its reader, keeps its intervals, and ends by itself. */
class RecordingTest {
    private val fixture = StreamFixture(Headset.Timeline.RECORDED, receiveBufferBytes = 16_384)
    private val headset = fixture.headset
    private val firstCapture = fixture.now

    @AfterEach
    fun close() = fixture.close()

    @Test
    fun nothingIsDroppedForASlowReaderAndStampsAreCapturesPlusOneConstant() = runBlocking<Unit> {
        val held = listOf("world_left", "sensors")
        val session = fixture.start("""{"world_left": {}, "gyro_left": {}}""", held)
        val captures = List(60) { firstCapture + it * 50_000_000L + it % 7 }
        val player = launch(Dispatchers.Default) {
            for ((number, capture) in captures.withIndex()) {
                val image = headset.image(capture, number.toLong(), rowBytes = 256, height = 256)
                headset.deliver(StreamTable.worldLeft, image)
                headset.deliver(StreamTable.gyroLeft, VectorSample(capture, 0.0, 0.0, 0.0))
            }
            headset.end(StreamTable.worldLeft, null)
            headset.end(StreamTable.gyroLeft, null)
        }
        session.await(HostFrame.STATUS)
        assertFalse(player.isCompleted, "the recording waits for the reader")
        session.release("world_left")
        session.release("sensors")
        session.await(HostFrame.BYE)
        session.awaitEnds()
        for (topic in listOf("world_left/image_raw", "world_left/metadata", "gyro_left/imu")) {
            val frames = session.data(topic)
            assertEquals((0L..59).toList(), frames.map { it.sequence }, topic)
            assertEquals(captures.map { it - firstCapture }, frames.map { it.captureNanos - frames[0].captureNanos })
        }
        val firsts = listOf("world_left/image_raw", "gyro_left/imu").map { session.data(it)[0].captureNanos }
        assertEquals(1, firsts.distinct().size, "the constant is the same for all streams")
        for (counts in fixture.finish(session).values) assertTrue(counts.dropped.isEmpty(), "$counts")
    }

    @Test
    fun aRecordingThatIsOverEndsTheSessionInOrder() = runBlocking<Unit> {
        fixture.streamer.state.test {
            assertEquals(StreamerState.Connecting(null), awaitItem())
            val session = fixture.start("""{"gyro_left": {}}""")
            assertEquals(StreamerState.Connected("scripted"), awaitItem())
            headset.deliver(StreamTable.gyroLeft, VectorSample(1, 0.0, 0.0, 0.0))
            headset.end(StreamTable.gyroLeft, null)
            assertEquals("""{"reason":"the recording is over"}""", session.await(HostFrame.BYE).body.decodeToString())
            assertEquals(StreamerState.Ended("the recording is over"), awaitItem())
            session.awaitData("gyro_left/imu")
        }
    }

    @Test
    fun aStreamIsReconfiguredWhileATransformWaitsForTheLink() = runBlocking<Unit> {
        val first = fixture.start("""{"world_left": {"update_rate": 30}, "tf": {}}""")
        headset.deliver(StreamTable.worldLeft, headset.image(firstCapture))
        headset.deliver(StreamTable.headPose, PoseSample(firstCapture, Transform.IDENTITY))
        first.awaitData("/tf")
        first.cut()
        val second = fixture.host.awaitHello()
        val waiting = launch(start = CoroutineStart.UNDISPATCHED) {
            headset.deliver(StreamTable.headPose, PoseSample(firstCapture + 1, Transform.IDENTITY))
        }
        second.welcome(fixture.host.received())
        second.configure(1, """{"world_left": {"update_rate": 10}, "tf": {}}""")
        second.start(1)
        waiting.join()
        assertEquals(1, second.awaitData("/tf").size)
        assertEquals(Counters(2, 2, emptyMap()), fixture.finish(second)["/tf"])
    }

    @Test
    fun aPausedStreamOfARecordingKeepsItsRestWhenTheOthersEnd() = runBlocking<Unit> {
        val session = fixture.start("""{"gyro_left": {}, "battery": {}}""")
        headset.deliver(StreamTable.gyroLeft, VectorSample(firstCapture, 0.0, 0.0, 0.0))
        headset.awaitRunning(StreamTable.battery)
        session.configure(2, "{}")
        headset.awaitStopped(StreamTable.gyroLeft)
        session.configure(3, """{"gyro_left": {}}""")
        session.start(3)
        headset.deliver(StreamTable.gyroLeft, VectorSample(firstCapture + 1, 0.0, 0.0, 0.0))
        assertEquals(2, session.awaitData("gyro_left/imu", 2).size)
        assertEquals(StreamerState.Connected("scripted"), fixture.streamer.state.value)
        headset.end(StreamTable.gyroLeft, null)
        headset.awaitStopped(StreamTable.gyroLeft)
        session.configure(4, """{"gyro_left": {}, "battery": {}}""")
        session.start(4)
        headset.deliver(StreamTable.battery, BatterySample(firstCapture + 2, 4f, -1f, 0.5f, ChargeStatus.UNKNOWN))
        session.awaitData("battery")
        headset.end(StreamTable.battery, null)
        val bye = session.await(HostFrame.BYE)
        assertEquals("""{"reason":"the recording is over"}""", bye.body.decodeToString())
    }

    @Test
    fun whatFailsInARecordingFailsForGood() = runBlocking<Unit> {
        val session = fixture.start("""{"world_left": {}, "gyro_left": {}}""")
        headset.deliver(StreamTable.worldLeft, headset.image(firstCapture))
        headset.end(StreamTable.worldLeft, IOException("no image"))
        val error = session.await(HostFrame.ERROR).json
        assertEquals("\"stream world_left ended: IOException: no image\"", error["message"].toString())
        session.await(HostFrame.CHANNEL_END, index = 2)
        assertEquals(StreamState.Failed("IOException: no image"), fixture.streamer.streams.value["world_left"])
        headset.end(StreamTable.gyroLeft, null)
        session.await(HostFrame.BYE)
    }

    @Test
    fun aRecordingGoesOnWhereItWasWhenTheLinkIsBack() = runBlocking<Unit> {
        val first = fixture.start("""{"gyro_left": {}}""")
        val player = launch(Dispatchers.Default) {
            repeat(500) { headset.deliver(StreamTable.gyroLeft, VectorSample(firstCapture + it, 0.0, 0.0, 0.0)) }
        }
        first.awaitData("gyro_left/imu", 5)
        first.cut()
        val second = fixture.session("""{"gyro_left": {}}""")
        player.join()
        headset.end(StreamTable.gyroLeft, null)
        second.await(HostFrame.BYE)
        second.awaitEnds()
        val frames = first.data("gyro_left/imu") + second.data("gyro_left/imu")
        val constant = frames[0].captureNanos - firstCapture
        for (frame in frames) assertEquals(firstCapture + frame.sequence + constant, frame.captureNanos)
        val counts = fixture.finish(second).getValue("gyro_left/imu")
        assertEquals(500, counts.produced)
        assertEquals(500L - frames.size, counts.dropped.values.sum())
    }
}
