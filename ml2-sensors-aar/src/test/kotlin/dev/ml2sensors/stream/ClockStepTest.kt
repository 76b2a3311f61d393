package dev.ml2sensors.stream

import dev.ml2sensors.message.transform
import dev.ml2sensors.session.HostFrame
import dev.ml2sensors.session.HostSession
import dev.ml2sensors.source.PoseSample
import dev.ml2sensors.source.VectorSample
import dev.ml2sensors.table.StreamTable
import kotlinx.coroutines.runBlocking
import kotlinx.serialization.json.jsonObject
import kotlinx.serialization.json.jsonPrimitive
import org.junit.jupiter.api.AfterEach
import org.junit.jupiter.api.Test
import kotlin.random.Random
import kotlin.test.assertEquals

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
        session.awaitClock("state", "synchronised")
        // Seen within 0.2 s and told within another, so captures of then are still withheld
        fixture.host.clockOffsetNanos -= 1_900_000_000
        assertEquals("0", session.awaitClock("steps", "1").getValue("epoch").jsonPrimitive.content)
        val pose = Random(1).transform()
        // The head's around the image's, which is known between two of them only
        headset.deliver(StreamTable.headPose, PoseSample(fixture.now, pose))
        headset.deliver(StreamTable.worldLeft, headset.image(fixture.now, pose = pose))
        headset.deliver(StreamTable.headPose, PoseSample(fixture.now, pose))
        headset.deliver(StreamTable.gyroLeft, VectorSample(fixture.now, 0.0, 0.0, 0.0))
        val counters = fixture.finish(session)
        for (topic in listOf("world_left/image_raw", "world_left/camera_info", "world_left/metadata")) {
            assertEquals(Counters(1, 0, mapOf("clock_step" to 1)), counters[topic], topic)
        }
        assertEquals(Counters(3, 0, mapOf("clock_step" to 3)), counters["/tf"], "the head's and the image's")
        assertEquals(Counters(2, 1, mapOf("clock_step" to 1)), counters["gyro_left/imu"])
    }

    private fun HostSession.awaitClock(key: String, value: String) = generateSequence(0) { it + 1 }
        .map { await(HostFrame.STATUS, it).json.getValue("clock").jsonObject }
        .first { it.getValue(key).jsonPrimitive.content == value }
}
