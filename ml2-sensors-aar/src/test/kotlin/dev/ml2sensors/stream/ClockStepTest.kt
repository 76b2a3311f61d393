package dev.ml2sensors.stream

import dev.ml2sensors.TEST_LIMIT
import dev.ml2sensors.message.transform
import dev.ml2sensors.session.HostFrame
import dev.ml2sensors.session.HostSession
import dev.ml2sensors.source.PoseSample
import dev.ml2sensors.source.VectorSample
import dev.ml2sensors.table.StreamTable
import kotlinx.coroutines.delay
import kotlinx.coroutines.runBlocking
import kotlinx.coroutines.withTimeout
import kotlinx.serialization.json.jsonObject
import kotlinx.serialization.json.jsonPrimitive
import org.junit.jupiter.api.AfterEach
import org.junit.jupiter.api.Test
import kotlin.random.Random
import kotlin.test.assertEquals
import kotlin.time.Duration.Companion.milliseconds

class ClockStepTest {
    private val fixture = StreamFixture()
    private val headset = fixture.headset

    @AfterEach
    fun close() = fixture.close()

    @Test
    fun aHostThatStepsBackCostsEveryChannelOfACapture() = runBlocking<Unit> {
        val session = fixture.start("""{"world_left": {}, "gyro_left": {}, "tf": {}}""")
        headset.deliver(StreamTable.gyroLeft, VectorSample(fixture.now, 0.0, 0.0, 0.0))
        session.awaitData("gyro_left/imu")
        session.awaitSynchronised()
        // Seen within 0.2 s, so captures of then are withheld
        fixture.host.clockOffsetNanos -= 1_900_000_000
        withTimeout(TEST_LIMIT) { while (fixture.streamer.clock().steps == 0L) delay(1.milliseconds) }
        val captureNanos = fixture.now
        assertEquals(0, fixture.streamer.clock().epoch)
        val pose = Random(1).transform()
        // The head's around the image's, which is known between two of them only
        headset.deliver(StreamTable.headPose, PoseSample(captureNanos, pose))
        headset.deliver(StreamTable.worldLeft, headset.image(captureNanos + 1, pose = pose))
        headset.deliver(StreamTable.headPose, PoseSample(captureNanos + 2, pose))
        headset.deliver(StreamTable.gyroLeft, VectorSample(captureNanos, 0.0, 0.0, 0.0))
        val counters = fixture.finish(session)
        for (topic in listOf("world_left/image_raw", "world_left/camera_info", "world_left/metadata")) {
            assertEquals(Counters(1, 0, mapOf("clock_step" to 1)), counters[topic], topic)
        }
        assertEquals(Counters(3, 0, mapOf("clock_step" to 3)), counters["/tf"], "the head's and the image's")
        assertEquals(Counters(2, 1, mapOf("clock_step" to 1)), counters["gyro_left/imu"])
    }

    private fun HostSession.awaitSynchronised() = generateSequence(0) { it + 1 }
        .map { await(HostFrame.STATUS, it).json.getValue("clock").jsonObject.getValue("state").jsonPrimitive.content }
        .first { it == "synchronised" }
}
