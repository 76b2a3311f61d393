package dev.ml2sensors.stream

import dev.ml2sensors.message.CameraInfo
import dev.ml2sensors.message.CompressedImage
import dev.ml2sensors.message.Header
import dev.ml2sensors.message.Image
import dev.ml2sensors.message.RegionOfInterest
import dev.ml2sensors.message.StringMessage
import dev.ml2sensors.message.Transform
import dev.ml2sensors.session.HostFrame
import dev.ml2sensors.session.HostSession
import dev.ml2sensors.source.CaptureMetadata
import dev.ml2sensors.source.Distortion
import dev.ml2sensors.source.DropReason
import dev.ml2sensors.source.LostSamples
import dev.ml2sensors.table.StreamTable
import kotlinx.coroutines.runBlocking
import kotlinx.serialization.json.Json
import kotlinx.serialization.json.double
import kotlinx.serialization.json.jsonObject
import kotlinx.serialization.json.jsonPrimitive
import org.junit.jupiter.api.AfterEach
import org.junit.jupiter.api.Test
import java.nio.ByteBuffer
import kotlin.test.assertContentEquals
import kotlin.test.assertEquals
import kotlin.test.assertTrue

class CameraTest {
    private val fixture = StreamFixture()
    private val headset = fixture.headset

    @AfterEach
    fun close() = fixture.close()

    @Test
    fun colourImagesWithoutAPoseAreCountedInAnEvent() = runBlocking<Unit> {
        val session = fixture.start("""{"color": {}, "world_left": {}}""")
        repeat(30) {
            headset.deliver(StreamTable.worldLeft, headset.image(fixture.now, it.toLong()))
            headset.deliver(StreamTable.color, headset.image(fixture.now, it.toLong()))
        }
        val event = session.await(HostFrame.EVENT).json
        assertEquals("\"images_without_pose\"", "${event["event"]}")
        assertEquals("\"30 images of color had no pose since the stream began\"", "${event["text"]}")
    }

    @Test
    fun imageInfoAndMetadataOfACaptureShareStampAndFrame() = runBlocking<Unit> {
        val session = fixture.start("""{"world_left": {}, "world_right": {}}""")
        val base = fixture.now
        for (number in 0L..4) {
            for (stream in listOf(StreamTable.worldLeft, StreamTable.worldRight)) {
                headset.deliver(stream, headset.image(base + number * 33_333_333, number, intrinsics = LENS))
            }
        }
        val stamps = List(5) { number ->
            val headers = listOf("world_left", "world_right").flatMap { headers(session, it, number) }
            val frames = headers.map { it.frameId }.toSet()
            assertEquals(setOf("world_left_optical_frame", "world_right_optical_frame"), frames)
            headers.map { it.stamp.toNanos() }.distinct().single()
        }
        assertEquals(stamps.sorted().distinct(), stamps)
        for (topic in listOf("world_left/image_raw", "world_left/camera_info", "world_left/metadata")) {
            assertEquals(stamps, session.data(topic).map { it.captureNanos }, topic)
        }
    }

    @Test
    fun rawImagesArriveByteForByte() = runBlocking<Unit> {
        val session = fixture.start("""{"world_center": {}, "eye_nasal_left": {}}""")
        headset.deliver(StreamTable.worldCenter, headset.image(fixture.now, number = 5, rowBytes = 48, height = 40))
        val image = session.awaitData("world_center/image_raw")[0].message<Image>()
        assertEquals(listOf(40u, 48u, 48u), listOf(image.height, image.width, image.step))
        assertEquals("mono8" to 0.toUByte(), image.encoding to image.isBigendian)
        assertContentEquals(FakeHeadset.pattern("image", 5, 40 * 48), image.data.bytes())
    }

    @Test
    fun jpegsArriveByteForByte() = runBlocking<Unit> {
        val session = fixture.start("""{"color": {}, "mixed_reality": {}}""")
        for (stream in listOf(StreamTable.color, StreamTable.mixedReality)) {
            headset.deliver(stream, headset.image(fixture.now, number = 9, rowBytes = 1, height = 1234))
            val jpeg = session.awaitData("${stream.id}/image_raw/compressed")[0].message<CompressedImage>()
            assertEquals("rgb8; jpeg compressed bgr8", jpeg.format)
            assertEquals("color_optical_frame", jpeg.header.frameId)
            assertContentEquals(FakeHeadset.pattern("image", 9, 1234), jpeg.data.bytes())
        }
    }

    @Test
    fun depthComesWithConfidenceAndFlagsWhenTheyAreOn() = runBlocking<Unit> {
        val session = fixture.start("""{"depth": {"confidence": true, "flags": true}}""")
        val roles = listOf("image", "confidence", "flags")
        headset.deliver(StreamTable.depth, headset.image(fixture.now, roles = roles))
        val images = listOf("depth/image_raw", "depth/confidence", "depth/flags").map {
            session.awaitData(it)[0].message<Image>()
        }
        assertEquals(listOf("32FC1", "32FC1", "32SC1"), images.map { it.encoding })
        assertEquals(1, images.map { it.header }.distinct().size)
        for ((role, image) in roles.zip(images)) {
            assertContentEquals(FakeHeadset.pattern(role, 0, 64 * 32), image.data.bytes())
        }
    }

    @Test
    fun whatIsSwitchedOffHasNoChannel() {
        val topics = setOf("depth/image_raw", "depth/camera_info", "depth/metadata")
        assertEquals(topics, fixture.start("""{"depth": {}}""").channels().keys)
        fixture.close()
        StreamFixture().use {
            val session = it.start("""{"depth": {"confidence": false, "flags": true}}""")
            assertEquals(topics + "depth/flags", session.channels().keys)
        }
    }

    @Test
    fun cameraInfoIsTheDevicesProjection() = runBlocking<Unit> {
        val session = fixture.start("""{"world_left": {}}""")
        headset.deliver(StreamTable.worldLeft, headset.image(fixture.now, intrinsics = LENS))
        val info = session.awaitData("world_left/camera_info")[0].message<CameraInfo>()
        assertEquals(64u to 32u, info.width to info.height)
        assertEquals("plumb_bob", info.distortionModel)
        assertContentEquals(doubleArrayOf(0.1, -0.2, 0.001, -0.002, 0.05), info.d)
        assertContentEquals(doubleArrayOf(100.0, 0.0, 32.5, 0.0, 110.0, 16.25, 0.0, 0.0, 1.0), info.k)
        assertContentEquals(doubleArrayOf(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0), info.r)
        val p = doubleArrayOf(100.0, 0.0, 32.5, 0.0, 0.0, 110.0, 16.25, 0.0, 0.0, 0.0, 1.0, 0.0)
        assertContentEquals(p, info.p)
        assertEquals(0u to 0u, info.binningX to info.binningY)
        assertEquals(RegionOfInterest(0u, 0u, 0u, 0u, false), info.roi)
        val fisheye = LENS.copy(distortion = Distortion.Equidistant(1.0, 2.0, 3.0, 4.0))
        headset.deliver(StreamTable.worldLeft, headset.image(fixture.now, intrinsics = fisheye))
        val equidistant = session.awaitData("world_left/camera_info", 2)[1].message<CameraInfo>()
        assertEquals("equidistant" to listOf(1.0, 2.0, 3.0, 4.0), equidistant.distortionModel to equidistant.d.toList())
    }

    @Test
    fun metadataHasAStableSchemaAndNothingIsRounded() = runBlocking<Unit> {
        val session = fixture.start("""{"world_left": {}}""")
        val metadata = CaptureMetadata(1_234_567, 1.0 / 3, 2.5, "off")
        headset.deliver(StreamTable.worldLeft, headset.image(fixture.now, 77, intrinsics = LENS, metadata = metadata))
        val frame = session.awaitData("world_left/metadata")[0]
        val stamp = frame.captureNanos
        val expected =
            """{"stamp": {"sec": ${stamp / 1_000_000_000}, "nanosec": ${stamp % 1_000_000_000}},
                "frame_id": "world_left_optical_frame", "frame_number": 77, "exposure_ns": 1234567,
                "analog_gain": 0.3333333333333333, "digital_gain": 2.5,
                "intrinsics": {"width": 64, "height": 32, "focal_length": [100.0, 110.0],
                    "principal_point": [32.5, 16.25], "distortion_model": "plumb_bob",
                    "distortion": [0.1, -0.2, 0.001, -0.002, 0.05]},
                "illumination": "off"}"""
        assertEquals(Json.parseToJsonElement(expected), Json.parseToJsonElement(frame.message<StringMessage>().data))
    }

    @Test
    fun aLensThatRosDoesNotKnowIsPublishedAsTheNearestAndStatedAsItIs() = runBlocking<Unit> {
        val session = fixture.start("""{"world_left": {}}""")
        val lens = LENS.copy(distortion = Distortion.FisheyeTangential(0.1, 0.02, 0.003, 0.0004, 1e-3, 2e-3))
        headset.deliver(StreamTable.worldLeft, headset.image(fixture.now, intrinsics = lens))
        val info = session.awaitData("world_left/camera_info")[0].message<CameraInfo>()
        assertEquals("equidistant" to 4, info.distortionModel to info.d.size)
        val text = session.awaitData("world_left/metadata")[0].message<StringMessage>().data
        val metadata = Json.parseToJsonElement(text).jsonObject
        val intrinsics = metadata.getValue("intrinsics").jsonObject
        assertEquals(Json.parseToJsonElement("\"fisheye_tangential\""), intrinsics["distortion_model"])
        assertEquals(Json.parseToJsonElement("[0.1, 0.02, 0.003, 4.0E-4, 0.001, 0.002]"), intrinsics["distortion"])
        val residualPx = metadata.getValue("camera_info_max_residual_px").jsonPrimitive.double
        assertTrue(residualPx in 0.001..1.0, "found $residualPx")
    }

    @Test
    fun whatTheDeviceDoesNotSayIsAbsent() = runBlocking<Unit> {
        val session = fixture.start("""{"eye_temple_left": {}, "world_left": {}, "tf": {}}""")
        val pose = Transform.IDENTITY
        headset.deliver(StreamTable.eyeTempleLeft, headset.image(fixture.now, pose = pose, intrinsics = LENS.copy()))
        headset.deliver(StreamTable.worldLeft, headset.image(fixture.now))
        val metadata = session.awaitData("world_left/metadata")[0].message<StringMessage>()
        val keys = Json.parseToJsonElement(metadata.data).jsonObject.keys
        assertEquals(setOf("stamp", "frame_id", "frame_number"), keys)
        val counters = fixture.finish(session)
        assertEquals(0, counters.getValue("world_left/camera_info").produced)
        assertEquals(0, counters.getValue("/tf").produced, "eye cameras have no pose, and the other had none")
    }

    @Test
    fun capturesThatTheSourceLostAreGapsInEveryTopic() = runBlocking<Unit> {
        val session = fixture.start("""{"world_left": {}}""")
        headset.deliver(StreamTable.worldLeft, headset.image(fixture.now, intrinsics = LENS))
        headset.deliver(StreamTable.worldLeft, LostSamples(fixture.now, 3, DropReason.NO_BUFFER))
        headset.deliver(StreamTable.worldLeft, headset.image(fixture.now, intrinsics = LENS))
        val counters = fixture.finish(session)
        for (topic in listOf("world_left/image_raw", "world_left/camera_info", "world_left/metadata")) {
            assertEquals(listOf(0L, 4L), session.data(topic).map { it.sequence })
            assertEquals(Counters(5, 2, mapOf("no_buffer" to 3)), counters[topic])
        }
    }

    @Test
    fun anEmptyImageIsAMessageToo() = runBlocking<Unit> {
        val session = fixture.start("""{"color": {}}""")
        headset.deliver(StreamTable.color, headset.image(fixture.now, rowBytes = 0))
        val jpeg = session.awaitData("color/image_raw/compressed")[0].message<CompressedImage>()
        assertEquals(0, jpeg.data.remaining())
        assertTrue(fixture.finish(session).values.all { it.dropped.isEmpty() })
    }

    /** Returns the headers of capture [number], in image and camera_info, and from the metadata's JSON. */
    private fun headers(session: HostSession, camera: String, number: Int): List<Header> {
        fun at(suffix: String): HostFrame = session.awaitData("$camera/$suffix", number + 1)[number]
        val metadata = Json.parseToJsonElement(at("metadata").message<StringMessage>().data).jsonObject
        val json = """{"stamp": ${metadata["stamp"]}, "frameId": ${metadata["frame_id"]}}"""
        return listOf(
            at("image_raw").message<Image>().header,
            at("camera_info").message<CameraInfo>().header,
            Json.decodeFromString<Header>(json),
        )
    }

    private fun ByteBuffer.bytes() = ByteArray(remaining()).also(duplicate()::get)

    private companion object {
        val LENS = CameraFixtures.pinhole(64, 32)
    }
}
