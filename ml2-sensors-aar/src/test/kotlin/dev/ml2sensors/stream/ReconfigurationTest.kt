package dev.ml2sensors.stream

import dev.ml2sensors.message.Transform
import dev.ml2sensors.session.HostFrame
import dev.ml2sensors.source.Answer
import dev.ml2sensors.source.BatterySample
import dev.ml2sensors.source.ChargeStatus
import dev.ml2sensors.source.PoseSample
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.source.VectorSample
import dev.ml2sensors.table.StreamTable
import dev.ml2sensors.test
import kotlinx.coroutines.Dispatchers
import kotlinx.coroutines.cancelAndJoin
import kotlinx.coroutines.launch
import kotlinx.coroutines.runBlocking
import kotlinx.serialization.json.Json
import kotlinx.serialization.json.jsonObject
import org.junit.jupiter.api.AfterEach
import org.junit.jupiter.api.Test
import kotlin.test.assertEquals
import kotlin.test.assertFalse
import kotlin.test.assertTrue

class ReconfigurationTest {
    private val fixture = StreamFixture()
    private val headset = fixture.headset

    @AfterEach
    fun close() = fixture.close()

    @Test
    fun eachStreamIsAppliedAdjustedOrRefused() = runBlocking<Unit> {
        headset.answers[StreamTable.depth] = Answer.Adjusted(StreamValues(rateHz = 30), "60 delivers 30")
        headset.answers[StreamTable.color] = Answer.Refused("no camera permission")
        fixture.streamer.streams.test {
            assertEquals(emptyMap(), awaitItem())
            fixture.streamer.start()
            val session = fixture.host.awaitHello()
            session.welcome()
            val answers = session.configure(
                1,
                """{"world_left": {"update_rate": 30, "format": "Grayscale"}, "depth": {"update_rate": 60}, "color": {},
                    "taste": {}}""",
            )
            val expected =
                """{"world_left": {"result": "applied", "values": {"update_rate": 30, "format": "Grayscale"}},
                    "depth": {"result": "adjusted", "values": {"update_rate": 30}, "reason": "60 delivers 30"},
                    "color": {"result": "refused", "reason": "no camera permission"},
                    "taste": {"result": "refused", "reason": "this headset has no stream taste"}}"""
            assertEquals(Json.parseToJsonElement(expected), answers)
            val states = awaitItem()
            assertEquals(StreamState.Running(StreamValues(rateHz = 30), "60 delivers 30"), states["depth"])
            assertEquals(StreamState.Refused("no camera permission"), states["color"])
            assertEquals(setOf("world_left", "depth"), session.channels().keys.map { it.substringBefore('/') }.toSet())
        }
    }

    @Test
    fun aStreamWhoseNegotiationThrowsIsRefusedAloneAndNoCapability() {
        headset.broken[StreamTable.color] = SecurityException("camera disabled by policy")
        fixture.streamer.start()
        val session = fixture.host.awaitHello()
        assertFalse("\"color\"" in session.hello.json.getValue("capabilities").toString())
        session.welcome()
        val answers = session.configure(1, """{"color": {}, "depth": {}}""")
        val refused = """{"result": "refused", "reason": "SecurityException: camera disabled by policy"}"""
        assertEquals(Json.parseToJsonElement(refused), answers["color"])
        assertEquals("\"applied\"", answers.getValue("depth").jsonObject["result"].toString())
    }

    @Test
    fun streamsThatTheHeadsetRefusesAreNoCapability() {
        for (stream in listOf(StreamTable.gyroLeft, StreamTable.headPose, StreamTable.color)) {
            headset.answers[stream] = Answer.Refused("not there")
        }
        fixture.streamer.start()
        val hello = fixture.host.awaitHello().hello.json
        val absent = listOf("gyro_left", "imu_left", "head_pose", "tf", "color").map { "\"$it\"" }
        val streams = hello.getValue("capabilities").toString()
        assertEquals(emptyList(), absent.filter { it in streams })
        assertTrue(listOf("accel_left", "imu_right", "world_left").all { "\"$it\"" in streams })
    }

    @Test
    fun onlyTheStreamsThatChangeAreRestarted() = runBlocking<Unit> {
        val session = fixture.start("""{"gyro_left": {}, "world_left": {}, "depth": {"update_rate": 5}}""")
        val gyroscope = launch(Dispatchers.Default) {
            for (count in 1..Int.MAX_VALUE) {
                headset.deliver(StreamTable.gyroLeft, VectorSample(fixture.now, 0.0, 0.0, 0.0))
                session.awaitData("gyro_left/imu", count)
            }
        }
        headset.deliver(StreamTable.worldLeft, headset.image(fixture.now))
        headset.deliver(StreamTable.depth, headset.image(fixture.now))
        session.configure(2, """{"gyro_left": {}, "depth": {"update_rate": 30}, "battery": {}}""")
        headset.awaitStopped(StreamTable.worldLeft)
        session.start(2)
        headset.deliver(StreamTable.depth, headset.image(fixture.now))
        session.awaitData("gyro_left/imu", session.data("gyro_left/imu").size + 20)
        gyroscope.cancelAndJoin()
        val counters = fixture.finish(session)
        val numbers = session.data("gyro_left/imu").map { it.sequence }
        assertEquals(numbers.indices.map { it.toLong() }, numbers, "the gyroscope lost nothing")
        assertEquals(Counters(2, 2, emptyMap()), counters["depth/image_raw"])
        val ended = session.frames(HostFrame.CHANNEL_END).map { it.json["id"] }
        val left = session.channels().filterKeys { it.startsWith("world_left") }.values.map { it["id"] }
        assertEquals(left.toSet(), ended.toSet())
    }

    @Test
    fun theFramePrefixStandsBeforeEveryFrameAndAnotherOneRestartsTheStream() = runBlocking<Unit> {
        val session = fixture.start("{}")
        for ((request, prefix) in listOf(2L to "robot1/", 3L to "robot2/")) {
            session.configure(request, """{"gyro_left": {}, "tf": {}}""", prefix)
            session.start(request)
            headset.deliver(StreamTable.gyroLeft, VectorSample(fixture.now, 0.0, 0.0, 0.0))
            headset.deliver(StreamTable.headPose, PoseSample(fixture.now, Transform.IDENTITY))
            val index = request.toInt() - 1
            val gyroscope = session.awaitData("gyro_left/imu", index).last().body.decodeToString()
            assertTrue("${prefix}imu_left_frame" in gyroscope)
            val tree = session.awaitData("/tf", index).last().body.decodeToString()
            assertTrue("${prefix}magicleap_world" in tree && "${prefix}head_frame" in tree)
        }
        assertEquals("\"robot1/imu_left_frame\"", session.channels().getValue("gyro_left/imu")["frame_id"].toString())
    }

    @Test
    fun theTreeThatIsAddedLaterCarriesNothingBeforeItsStart() = runBlocking<Unit> {
        val session = fixture.start("""{"world_left": {}}""")
        val camera = launch(Dispatchers.Default) {
            while (true) {
                headset.deliver(StreamTable.worldLeft, headset.image(fixture.now, pose = Transform.IDENTITY))
            }
        }
        val head = launch(Dispatchers.Default) {
            while (true) headset.deliver(StreamTable.headPose, PoseSample(fixture.now, Transform.IDENTITY))
        }
        session.awaitData("world_left/image_raw", 3)
        session.configure(2, """{"world_left": {}, "tf": {}}""")
        session.awaitData("world_left/image_raw", session.data("world_left/image_raw").size + 3)
        assertEquals(emptyList(), session.data("/tf"))
        session.start(2)
        session.awaitData("/tf", 3)
        camera.cancelAndJoin()
        head.cancelAndJoin()
    }

    @Test
    fun anOlderStartBeginsNothingOfANewerRequest() = runBlocking<Unit> {
        val streams = """{"battery": {}, "light_sensor": {}}"""
        val session = fixture.start(streams, held = listOf("time")) // so that START waits for stamps
        session.configure(2, """{"battery": {}, "gyro_left": {}}""")
        session.release("time")
        val delivery = launch { headset.deliver(StreamTable.gyroLeft, VectorSample(fixture.now, 0.0, 0.0, 0.0)) }
        headset.deliver(StreamTable.battery, BATTERY)
        assertTrue(delivery.isActive)
        session.start(2)
        delivery.join()
        assertFalse(headset.isRunning(StreamTable.lightSensor))
        session.awaitData("gyro_left/imu")
        session.awaitData("battery")
    }

    private companion object {
        val BATTERY = BatterySample(1, 4f, 1f, 0.5f, ChargeStatus.DISCHARGING)
    }
}
