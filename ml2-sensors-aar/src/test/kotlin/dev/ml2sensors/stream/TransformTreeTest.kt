package dev.ml2sensors.stream

import dev.ml2sensors.message.DiagnosticArray
import dev.ml2sensors.message.Matrix
import dev.ml2sensors.message.TFMessage
import dev.ml2sensors.message.Transform
import dev.ml2sensors.message.TransformStamped
import dev.ml2sensors.message.assertMatrix
import dev.ml2sensors.message.interpolate
import dev.ml2sensors.message.inverse
import dev.ml2sensors.message.times
import dev.ml2sensors.message.toMatrix
import dev.ml2sensors.message.transform
import dev.ml2sensors.session.HostFrame
import dev.ml2sensors.session.HostSession
import dev.ml2sensors.source.DropReason
import dev.ml2sensors.source.Headset
import dev.ml2sensors.source.LostSamples
import dev.ml2sensors.source.MapSample
import dev.ml2sensors.source.MapState
import dev.ml2sensors.source.Marker
import dev.ml2sensors.source.MarkersSample
import dev.ml2sensors.source.PoseSample
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable
import kotlinx.coroutines.runBlocking
import kotlinx.serialization.json.double
import kotlinx.serialization.json.jsonObject
import kotlinx.serialization.json.jsonPrimitive
import org.junit.jupiter.api.AfterEach
import org.junit.jupiter.api.Test
import kotlin.random.Random
import kotlin.test.assertEquals
import kotlin.test.assertTrue

class TransformTreeTest {
    private val fixture = StreamFixture()
    private val random = Random(11)

    @AfterEach
    fun close() = fixture.close()

    @Test
    fun withoutTransformsANewWorldIsReportedWhileAPoseIsSent() = runBlocking<Unit> {
        val session = fixture.start("""{"gaze": {}}""")
        fixture.headset.deliver(StreamTable.headPose, PoseSample(fixture.now, Transform.IDENTITY))
        fixture.headset.deliver(StreamTable.headPose, PoseSample(fixture.now, Transform.IDENTITY, isInNewWorld = true))
        val event = session.await(HostFrame.EVENT).json.getValue("event").jsonPrimitive.content
        assertEquals("tracking_new_session", event)
    }

    @Test
    fun everyImageHasATransformOfExactlyItsStamp() = runBlocking<Unit> {
        val session = fixture.start("""{"world_left": {}, "tf": {}}""")
        val poses = List(5) { random.transform() }
        val base = fixture.now
        fixture.head(base - 1, Transform.IDENTITY)
        for ((number, pose) in poses.withIndex()) fixture.camera(StreamTable.worldLeft, base + number * FRAME, pose)
        fixture.head(base + 5 * FRAME, Transform.IDENTITY)
        val images = session.awaitData("world_left/image_raw", 5)
        session.awaitData("/tf", 7)
        for ((image, pose) in images.zip(poses)) {
            val sent = session.transforms().filter { it.header.stamp.toNanos() == image.captureNanos }
            assertEquals(setOf("world_left_optical_frame", "world_left_frame"), sent.map { it.childFrameId }.toSet())
            assertEquals(setOf("magicleap_world"), sent.map { it.header.frameId }.toSet())
            assertMatrix(pose.toMatrix(), sent.of("world_left_optical_frame"))
            assertMatrix(pose.toMatrix() * OPTICAL_TO_BODY, sent.of("world_left_frame"))
        }
    }

    @Test
    fun theControllerIsAChildOfTheWorldAtEachOfItsStamps() = runBlocking<Unit> {
        val session = fixture.start("""{"controller": {}, "tf": {}}""")
        val pose = random.transform()
        fixture.headset.deliver(StreamTable.controller, PoseSample(fixture.now, pose))
        val sent = session.awaitData("controller", 1).single()
        session.awaitData("/tf", 1)
        val transform = session.transforms().single()
        assertEquals(sent.captureNanos, transform.header.stamp.toNanos())
        assertEquals("magicleap_world", transform.header.frameId)
        assertMatrix(pose.toMatrix(), session.transforms().of("controller_frame"))
    }

    @Test
    fun markersAreChildrenOfTheWorldWhileTheyAreTracked() = runBlocking<Unit> {
        val session = fixture.start("""{"markers": {}, "tf": {}}""")
        val poses = mapOf("marker_7" to random.transform(), "marker_9" to random.transform())
        val markers = poses.map { (frame, it) -> Marker(frame, frame, it, sizeM = 0.2, reprojectionErrorM = 0.0) }
        fixture.headset.deliver(StreamTable.markers, MarkersSample(fixture.now, emptyList()))
        fixture.headset.deliver(StreamTable.markers, MarkersSample(fixture.now + HEAD, markers))
        val sent = session.awaitData("markers", 2)[1]
        session.awaitData("/tf", 1)
        assertEquals(poses.keys, session.transforms().map { it.childFrameId }.toSet())
        for ((frame, pose) in poses) assertMatrix(pose.toMatrix(), session.transforms().of(frame))
        for (it in session.transforms()) {
            assertEquals(sent.captureNanos to "magicleap_world", it.header.stamp.toNanos() to it.header.frameId)
        }
    }

    @Test
    fun theMapIsTheParentOfTheWorldWhileTheHeadsetIsLocalizedInIt() = runBlocking<Unit> {
        val session = fixture.start("""{"map": {"localize": "Lab"}, "tf": {}}""")
        val origin = random.transform()
        val lab = MapState("localized", "good", emptyList(), "Lab", "0707", "on_device")
        var at = fixture.now // of the samples, since a state is repeated after a second
        suspend fun deliver(pose: Transform?, state: MapState) {
            fixture.headset.deliver(StreamTable.map, MapSample(at, pose, state))
            at += HEAD
        }
        deliver(null, lab.copy(localization = "pending", name = "", uuid = "", type = ""))
        deliver(origin, lab)
        deliver(origin, lab)
        deliver(null, lab.copy(confidence = "poor", errors = listOf("low_light", "excessive_motion")))
        deliver(null, lab.copy(name = "Office"))
        deliver(null, lab)
        val states = session.awaitData("map/state", 5).map { it.message<DiagnosticArray>().status.single() }
        assertEquals(
            listOf(
                "no transform: localization is pending",
                "localized in Lab",
                "no transform: confidence is poor, low_light, excessive_motion",
                "no transform: localized in Office, asked for Lab",
                "no transform: the head is not tracked",
            ),
            states.map { it.message },
        )
        assertEquals(listOf(1, 0, 1, 1, 1), states.map { it.level.toInt() })
        assertEquals("low_light excessive_motion", states[2].values.single { it.key == "errors" }.value)
        session.awaitData("/tf", 2)
        assertEquals(setOf("magicleap_map"), session.transforms().map { it.header.frameId }.toSet())
        assertMatrix(origin.inverse().toMatrix(), session.transforms().takeLast(1).of("magicleap_world"))
        assertEquals(2, fixture.finish(session).getValue("/tf").produced)
        assertEquals(listOf("map_localized", "map_lost"), session.events())
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
    fun anImageBetweenMissingPosesOfTheHeadDoesNotMoveItsMounting() = runBlocking<Unit> {
        val session = fixture.start("""{"world_left": {}, "depth": {}, "tf": {}}""")
        val mounting = random.transform()
        val base = fixture.now
        fixture.head(base, Transform.IDENTITY)
        fixture.camera(StreamTable.worldLeft, base, mounting)
        fixture.head(base + HEAD, Transform.IDENTITY)
        for (stream in listOf(StreamTable.worldLeft, StreamTable.depth)) {
            fixture.camera(stream, base + 2 * HEAD, random.transform())
        }
        fixture.headset.deliver(StreamTable.headPose, LostSamples(base + 2 * HEAD, 1, DropReason.SOURCE_LATE))
        fixture.head(base + 3 * HEAD, Transform.IDENTITY)
        fixture.finish(session)
        val last = session.transforms().map { it.header.stamp.toNanos() }.max()
        val sent = session.transforms().filter { it.header.stamp.toNanos() == last }
        val frames = setOf("head_frame", "world_left_frame", "world_left_optical_frame")
        assertEquals(frames, sent.map { it.childFrameId }.toSet())
        assertMatrix(mounting.toMatrix(), sent.of("world_left_optical_frame"))
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
        fixture.camera(StreamTable.worldLeft, base + HEAD / 2, Transform.IDENTITY)
        for (number in 1L..5) {
            fixture.head(base + number * HEAD, null)
            fixture.camera(StreamTable.worldLeft, base + number * HEAD, Transform.IDENTITY)
            fixture.camera(StreamTable.worldLeft, base + number * HEAD + HEAD / 2, Transform.IDENTITY)
        }
        fixture.head(base + 6 * HEAD, Transform.IDENTITY)
        fixture.finish(session)
        val stamps = session.transforms().map { it.header.stamp.toNanos() }.distinct()
        assertEquals(2, stamps.size)
        assertEquals(6.0, (stamps[1] - stamps[0]).toDouble() / HEAD, absoluteTolerance = 0.1)
    }

    @Test
    fun transformsThatAreGivenUpForLostHeadPosesAreCounted() = runBlocking<Unit> {
        val session = fixture.start("""{"world_left": {}, "tf": {}}""")
        val base = fixture.now
        fixture.camera(StreamTable.worldLeft, base - HEAD, Transform.IDENTITY) // before the tree began
        fixture.head(base, Transform.IDENTITY)
        fixture.headset.deliver(StreamTable.headPose, LostSamples(base + HEAD, 4, DropReason.SOURCE_LATE))
        fixture.camera(StreamTable.worldLeft, base + 3 * HEAD, Transform.IDENTITY)
        fixture.head(base + 5 * HEAD, Transform.IDENTITY)
        assertEquals(Counters(7, 2, mapOf("source_late" to 5)), fixture.finish(session)["/tf"])
    }

    @Test
    fun aFewHeadPosesThatAreLostAreBridged() = runBlocking<Unit> {
        val session = fixture.start("""{"world_left": {}, "tf": {}}""")
        val base = fixture.now
        fixture.head(base, Transform.IDENTITY)
        fixture.headset.deliver(StreamTable.headPose, LostSamples(base + HEAD, 1, DropReason.SOURCE_LATE))
        fixture.camera(StreamTable.worldLeft, base + HEAD, Transform.IDENTITY)
        fixture.head(base + 2 * HEAD, Transform.IDENTITY)
        assertEquals(Counters(4, 3, mapOf("source_late" to 1)), fixture.finish(session)["/tf"])
    }

    @Test
    fun aPoseOfTheFutureIsRefusedAndCountedAndHarmsNoOther() = runBlocking<Unit> {
        val session = fixture.start("""{"world_left": {}, "tf": {}}""")
        val base = fixture.now
        val future = base + 3_600_000_000_000
        fixture.head(future, Transform.IDENTITY)
        fixture.camera(StreamTable.worldLeft, future, Transform.IDENTITY)
        fixture.head(base, Transform.IDENTITY)
        fixture.camera(StreamTable.worldLeft, base, Transform.IDENTITY)
        val counters = fixture.finish(session)
        assertEquals(Counters(4, 2, mapOf("future_capture" to 2)), counters["/tf"])
        assertEquals(Counters(2, 1, mapOf("future_capture" to 1)), counters["world_left/image_raw"])
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
    fun aLossItsEndAndANewWorldAreReported() = runBlocking<Unit> {
        val session = fixture.start("""{"tf": {}}""")
        val base = fixture.now
        val isTracked = listOf(false, true, false, false, true, true)
        for ((number, tracked) in isTracked.withIndex()) {
            fixture.head(base + number * HEAD, Transform.IDENTITY.takeIf { tracked })
        }
        fixture.headset.deliver(
            StreamTable.headPose,
            PoseSample(base + 7 * HEAD, Transform.IDENTITY, isInNewWorld = true),
        )
        fixture.finish(session)
        assertEquals(listOf("tracking_lost", "tracking_recovered", "tracking_new_session"), session.events())
    }

    @Test
    fun transformsOfAnImageThatComesLateAreOlderThanTheLastAndNoneIsSaidTwice() = runBlocking<Unit> {
        val session = fixture.start("""{"world_left": {}, "tf": {}}""")
        val base = fixture.now
        for (number in 0L..5) fixture.head(base + number * HEAD, Transform.IDENTITY)
        for (number in 0L..2) fixture.camera(StreamTable.worldLeft, base + number * FRAME, Transform.IDENTITY)
        fixture.finish(session)
        val stamps = session.data("/tf").map { it.captureNanos }
        assertTrue(stamps != stamps.sorted(), "an image comes after the head's poses of its time")
        val sent = session.transforms().map { it.childFrameId to it.header.stamp }
        assertEquals(sent.toSet().size, sent.size)
        for (topic in listOf("world_left/image_raw", "world_left/metadata")) {
            val captures = session.data(topic).map { it.captureNanos }
            assertEquals(captures.sorted().distinct(), captures, topic)
        }
    }

    @Test
    fun eventsWithoutAReceiverAreBoundedAndSayHowLongAgoTheyHappened() = runBlocking<Unit> {
        val first = fixture.start("""{"tf": {}}""")
        fixture.head(fixture.now, Transform.IDENTITY)
        first.awaitData("/tf")
        first.cut()
        val second = fixture.host.awaitHello()
        repeat(100) {
            fixture.head(fixture.now, null)
            fixture.head(fixture.now, Transform.IDENTITY)
        }
        second.welcome(fixture.host.received())
        second.configure(1, "{}")
        fixture.finish(second)
        val events = second.frames(HostFrame.EVENT).map { it.json }
        assertEquals(64, events.size)
        assertTrue(events.all { it.getValue("age_s").jsonPrimitive.double >= 0 })
        assertEquals(
            "head tracking is lost: no transforms until it is recovered (136 events before this one were dropped)",
            events.first().getValue("text").jsonPrimitive.content,
        )
    }

    @Test
    fun theRigIsAHeadThatMovesAndSensorsThatStandOnItOnceTheyAreStable() = runBlocking<Unit> {
        val session = fixture.start("""{"world_left": {}, "depth": {}, "tf": {"layout": "rig"}}""")
        val mountings = mapOf(StreamTable.worldLeft to random.transform(), StreamTable.depth to random.transform())
        val base = fixture.now
        val heads = List(61) { random.transform() }
        fixture.head(base, heads[0])
        for (number in 1..60) {
            val between = heads[number - 1].interpolate(heads[number], 0.5)
            for ((stream, mounting) in mountings) {
                val isUnsteady = stream == StreamTable.depth && number % 2 == 0
                val shake = if (isUnsteady) random.transform() else Transform.IDENTITY
                fixture.camera(stream, base + number * HEAD - HEAD / 2, between * mounting * shake)
            }
            fixture.head(base + number * HEAD, heads[number])
        }
        fixture.finish(session)
        assertEquals(setOf("head_frame"), session.transforms().map { it.childFrameId }.toSet())
        val expected = heads.flatMapIndexed { number, head ->
            val isWithImage = number >= SensorMounting.WINDOW
            if (isWithImage) listOf(heads[number - 1].interpolate(head, 0.5), head) else listOf(head)
        }
        val sent = session.transforms().sortedBy { it.header.stamp.toNanos() }.map { it.transform }
        assertEquals(expected.size, sent.size, "at each head pose, and once at each image of a stable sensor")
        for ((pose, found) in expected.zip(sent)) assertMatrix(pose.toMatrix(), found.toMatrix())
        val static = session.data("/tf_static").single().message<TFMessage>().transforms
        assertEquals(
            listOf("head_frame" to "world_left_frame", "world_left_frame" to "world_left_optical_frame"),
            static.map { it.header.frameId to it.childFrameId },
        )
        val body = mountings.getValue(StreamTable.worldLeft).toMatrix() * OPTICAL_TO_BODY
        assertMatrix(body, static.of("world_left_frame"))
        assertMatrix(
            mountings.getValue(StreamTable.worldLeft).toMatrix(),
            static.of("world_left_frame") * static.of("world_left_optical_frame"),
        )
        assertEquals(listOf("mounting_stable"), session.events())
    }

    @Test
    fun staticTransformsAreSaidAgainToANewReceiver() = runBlocking<Unit> {
        val first = fixture.start(RIG)
        fixture.stand()
        first.awaitData("/tf_static")
        first.close()
        val second = fixture.session(RIG)
        assertEquals(2, second.awaitData("/tf_static").single().message<TFMessage>().transforms.size)
    }

    @Test
    fun staticTransformsOfAStreamThatStoppedAreTakenBack() = runBlocking<Unit> {
        val session = fixture.start(RIG)
        fixture.stand()
        session.configure(2, """{"tf": {"layout": "rig"}}""")
        assertEquals(listOf(2, 0), session.awaitData("/tf_static", 2).map { it.message<TFMessage>().transforms.size })
    }

    @Test
    fun theRigLayoutOfARecordingIsAdjustedToFlat() {
        StreamFixture(Headset.Timeline.RECORDED).use { recorded ->
            recorded.streamer.start()
            val session = recorded.host.awaitHello()
            session.welcome()
            val answer = session.configure(1, """{"tf": {"layout": "rig"}}""").getValue("tf").jsonObject
            assertEquals("\"adjusted\"" to """{"layout":"flat"}""", "${answer["result"]}" to "${answer["values"]}")
        }
    }

    /** Frames enough for a stable mounting of [StreamTable.worldLeft]. */
    private suspend fun StreamFixture.stand() {
        val base = now
        for (number in 0 until SensorMounting.WINDOW) {
            head(base + number * HEAD, Transform.IDENTITY)
            camera(StreamTable.worldLeft, base + number * HEAD, Transform.IDENTITY)
        }
    }

    private fun HostSession.events() =
        frames(HostFrame.EVENT).map { it.json.getValue("event").jsonPrimitive.content }

    private suspend fun StreamFixture.head(capture: Long, pose: Transform?) =
        headset.deliver(StreamTable.headPose, PoseSample(capture, pose))

    private suspend fun StreamFixture.camera(stream: StreamSpec, capture: Long, pose: Transform?) =
        headset.deliver(stream, headset.image(capture, pose = pose))

    private fun HostSession.transforms() = data("/tf").flatMap { it.message<TFMessage>().transforms }

    private fun List<TransformStamped>.of(child: String): Matrix = single {
        it.childFrameId == child
    }.transform.toMatrix()

    private companion object {
        const val HEAD = 16_666_666L
        const val RIG = """{"world_left": {}, "tf": {"layout": "rig"}}"""
        const val FRAME = 33_333_333L

        /** REP-103: a body's x, y, z in the optical axes of the same camera are z, -x, -y. */
        val OPTICAL_TO_BODY = Matrix.rotation(0, -1, 0, 0, 0, -1, 1, 0, 0)
    }
}
