package dev.ml2sensors.stream

import dev.ml2sensors.message.Matrix
import dev.ml2sensors.message.TFMessage
import dev.ml2sensors.message.Transform
import dev.ml2sensors.message.TransformStamped
import dev.ml2sensors.message.assertMatrix
import dev.ml2sensors.message.times
import dev.ml2sensors.message.toMatrix
import dev.ml2sensors.message.transform
import dev.ml2sensors.session.HostSession
import dev.ml2sensors.source.Headset
import dev.ml2sensors.source.PoseSample
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable
import kotlinx.coroutines.runBlocking
import kotlinx.serialization.json.jsonObject
import org.junit.jupiter.api.AfterEach
import org.junit.jupiter.api.Test
import org.junit.jupiter.api.Timeout
import kotlin.random.Random
import kotlin.test.assertEquals

@Timeout(60)
class TransformTreeTest {
    private val fixture = StreamFixture()
    private val random = Random(11)

    @AfterEach
    fun close() = fixture.close()

    @Test
    fun everyImageHasATransformOfExactlyItsStamp() = runBlocking<Unit> {
        val session = fixture.start("""{"world_left": {}, "tf": {}}""")
        val poses = List(5) { random.transform() }
        val base = fixture.now
        for ((number, pose) in poses.withIndex()) fixture.camera(StreamTable.worldLeft, base + number * FRAME, pose)
        val images = session.awaitData("world_left/image_raw", 5)
        session.awaitData("/tf", 5)
        for ((image, pose) in images.zip(poses)) {
            val sent = session.transforms().filter { it.header.stamp.toNanos() == image.captureNanos }
            assertEquals(setOf("world_left_optical_frame", "world_left_frame"), sent.map { it.childFrameId }.toSet())
            assertEquals(setOf("magicleap_world"), sent.map { it.header.frameId }.toSet())
            assertMatrix(pose.toMatrix(), sent.of("world_left_optical_frame"))
            assertMatrix(pose.toMatrix() * OPTICAL_TO_BODY, sent.of("world_left_frame"))
        }
    }

    @Test
    fun sensorsAreComposedWithTheHeadAtItsStamps() = runBlocking<Unit> {
        val session = fixture.start("""{"world_left": {}, "depth": {}, "tf": {}}""")
        val heads = List(4) { random.transform() }
        val mountings = mapOf(StreamTable.worldLeft to random.transform(), StreamTable.depth to random.transform())
        val base = fixture.now
        fixture.head(base, heads[0])
        for ((stream, mounting) in mountings) fixture.camera(stream, base, heads[0] * mounting)
        for (number in 1..3) fixture.head(base + number * HEAD, heads[number])
        session.awaitData("/tf", 6)
        val stamps = session.transforms().filter { it.childFrameId == "head_frame" }.map { it.header.stamp }
        assertEquals(4, stamps.size)
        for (number in 1..3) {
            val sent = session.transforms().filter { it.header.stamp == stamps[number] }
            assertEquals(5, sent.size)
            assertMatrix(heads[number].toMatrix(), sent.of("head_frame"))
            for ((stream, mounting) in mountings) {
                val optical = heads[number].toMatrix() * mounting.toMatrix()
                assertMatrix(optical, sent.of("${stream.id}_optical_frame"))
                assertMatrix(optical * OPTICAL_TO_BODY, sent.of("${stream.id}_frame"))
            }
        }
    }

    @Test
    fun thereIsAtMostOneTransformPerChildAndStamp() = runBlocking<Unit> {
        val session = fixture.start("""{"color": {}, "mixed_reality": {}, "depth": {}, "infra": {}, "tf": {}}""")
        val base = fixture.now
        for (number in 0L..30) {
            val pose = random.transform()
            fixture.head(base + number * HEAD, pose)
            if (number % 7 == 0L) fixture.head(base + number * HEAD, pose)
            for (stream in listOf(StreamTable.color, StreamTable.mixedReality, StreamTable.depth, StreamTable.infra)) {
                if (number % 2 == 0L) fixture.camera(stream, base + number * HEAD, pose)
            }
        }
        fixture.finish(session)
        val sent = session.transforms().map { it.childFrameId to it.header.stamp }
        assertEquals(sent.toSet().size, sent.size)
        assertEquals(31 * 5, sent.size, "head, and two frames of color and depth, at each head pose")
    }

    @Test
    fun nothingIsSentWhileTheHeadIsNotTracked() = runBlocking<Unit> {
        val session = fixture.start("""{"world_left": {}, "tf": {}}""")
        val base = fixture.now
        fixture.head(base, Transform.IDENTITY)
        fixture.camera(StreamTable.worldLeft, base, Transform.IDENTITY)
        for (number in 1L..5) {
            fixture.head(base + number * HEAD, null)
            fixture.camera(StreamTable.worldLeft, base + number * HEAD, null)
        }
        fixture.head(base + 6 * HEAD, Transform.IDENTITY)
        session.awaitData("world_left/image_raw", 6)
        fixture.finish(session)
        val first = session.data("world_left/image_raw")[0].captureNanos
        val stamps = session.transforms().map { it.header.stamp.toNanos() }.toSet()
        assertEquals(setOf(first, session.data("/tf").last().captureNanos), stamps)
    }

    @Test
    fun recordedPosesAreSentAsTheyAreAndNoneIsComposed() = runBlocking<Unit> {
        StreamFixture(Headset.Timeline.RECORDED).use { recorded ->
            val session = recorded.start("""{"world_left": {}, "tf": {}}""")
            val poses = List(6) { random.transform() }
            for (number in 0..5) {
                val capture = 1_000_000L + number
                if (number % 2 == 0) recorded.head(capture, poses[number])
                if (number % 2 == 1) recorded.camera(StreamTable.worldLeft, capture, poses[number])
            }
            session.awaitData("/tf", 6)
            val byCapture = session.data("/tf").associate { it.captureNanos to it.message<TFMessage>().transforms }
            val constant = byCapture.keys.min() - 1_000_000
            for ((stamp, sent) in byCapture) {
                val number = (stamp - constant - 1_000_000).toInt()
                val isHead = number % 2 == 0
                assertEquals(if (isHead) 1 else 2, sent.size)
                assertMatrix(
                    poses[number].toMatrix(),
                    sent.of(if (isHead) "head_frame" else "world_left_optical_frame"),
                )
            }
        }
    }

    @Test
    fun theRigLayoutIsAdjustedToFlat() {
        fixture.streamer.start()
        val session = fixture.host.awaitHello()
        session.welcome()
        val answer = session.configure(1, """{"tf": {"layout": "rig"}}""").getValue("tf").jsonObject
        assertEquals("\"adjusted\"" to """{"layout":"flat"}""", "${answer["result"]}" to "${answer["values"]}")
    }

    private fun StreamFixture.start(streams: String): HostSession {
        streamer.start()
        return session(streams)
    }

    private suspend fun StreamFixture.head(capture: Long, pose: Transform?) =
        headset.deliver(StreamTable.headPose, PoseSample(capture, pose))

    private suspend fun StreamFixture.camera(stream: StreamSpec, capture: Long, pose: Transform?) =
        headset.deliver(stream, headset.image(capture, pose = pose))

    private fun HostSession.transforms() = data("/tf").flatMap { it.message<TFMessage>().transforms }

    private fun List<TransformStamped>.of(child: String): Matrix = single {
        it.childFrameId == child
    }.transform.toMatrix()

    private companion object {
        const val HEAD = 16_666_667L
        const val FRAME = 33_333_333L

        /** REP-103: a body's x, y, z in the optical axes of the same camera are z, -x, -y. */
        val OPTICAL_TO_BODY = Matrix.rotation(0, -1, 0, 0, 0, -1, 1, 0, 0)
    }
}
