package dev.ml2sensors.stream

import dev.ml2sensors.message.Point
import dev.ml2sensors.message.Pose
import dev.ml2sensors.message.Quaternion
import dev.ml2sensors.message.Transform
import dev.ml2sensors.source.BatterySample
import dev.ml2sensors.source.ChargeStatus
import dev.ml2sensors.source.ImageSample
import dev.ml2sensors.source.InputSample
import dev.ml2sensors.source.MapSample
import dev.ml2sensors.source.MapState
import dev.ml2sensors.source.MarkersSample
import dev.ml2sensors.source.PoseSample
import dev.ml2sensors.source.PosesSample
import dev.ml2sensors.source.Sample
import dev.ml2sensors.source.ScalarSample
import dev.ml2sensors.source.VectorSample
import dev.ml2sensors.table.StreamTable
import kotlinx.coroutines.runBlocking
import kotlinx.serialization.json.JsonObject
import kotlinx.serialization.json.jsonPrimitive
import org.junit.jupiter.api.AfterEach
import org.junit.jupiter.api.Test
import kotlin.test.assertEquals

/** Every stream at once, against the topics of the specification. */
class StreamTableTest {
    private val fixture = StreamFixture()

    @AfterEach
    fun close() = fixture.close()

    @Test
    fun everyStreamIsAnnouncedAndCarriesItsMessage() = runBlocking<Unit> {
        val streams = StreamTable.all.joinToString { if (it == StreamTable.depth) DEPTH else "\"${it.id}\": {}" }
        val session = fixture.start("{$streams}")
        assertEquals(EXPECTED.trimIndent().lines().sorted(), session.channels().values.map(::line).sorted())
        for (stream in StreamTable.all) {
            val parts = mapOf("imu_left" to "left", "imu_right" to "right", "imu_compute_pack" to "compute_pack")
            if (stream.id in parts || stream == StreamTable.tf || stream == StreamTable.custom) continue
            val times = if (parts.values.any { stream.id == "gyro_$it" || stream.id == "accel_$it" }) 2 else 1
            fixture.headset.deliver(stream, sample(stream.id), if (stream == StreamTable.headPose) 2 else times)
        }
        for (topic in session.channels().keys) session.awaitData(topic)
        val counters = fixture.finish(session)
        assertEquals(session.channels().keys, counters.keys)
        for ((topic, counts) in counters) {
            assertEquals(counts.produced to emptyMap(), counts.sent to counts.dropped, topic)
        }
    }

    private fun line(channel: JsonObject): String {
        val keys = listOf("stream", "topic", "type", "lane", "qos", "frame_id")
        return keys.joinToString(" ") { channel.getValue(it).jsonPrimitive.content }
    }

    private fun sample(stream: String): Sample {
        val pose = Pose(Point(1.0, 2.0, 3.0), Quaternion.IDENTITY)
        return when {
            "eye" in stream -> fixture.headset.image(CAPTURE)
            stream == "depth" -> image(listOf(ImageSample.IMAGE, "confidence", "flags"))
            "gyro" in stream || "accel" in stream || "magnet" in stream -> VectorSample(CAPTURE, 1.0, 2.0, 3.0)
            "pressure" in stream || "light" in stream -> ScalarSample(CAPTURE, 1.0)
            "hand" in stream -> PosesSample(CAPTURE, listOf(pose))
            stream == "battery" -> BatterySample(CAPTURE, 4f, -1f, 0.5f, ChargeStatus.DISCHARGING)
            stream == "map" -> MapSample(CAPTURE, null, MapState("unknown", "poor", emptyList(), "", "", ""))
            stream == "markers" -> MarkersSample(CAPTURE, emptyList())
            stream == "controller_joy" -> InputSample(CAPTURE, 0f, false, false, false, 0f, 0f, 0f)
            stream in setOf("gaze", "head_pose", "controller") -> PoseSample(CAPTURE, Transform.IDENTITY)
            "world" in stream || stream in setOf("color", "mixed_reality", "infra") -> image()
            else -> error("there is no sample of $stream here")
        }
    }

    private fun image(roles: List<String> = listOf(ImageSample.IMAGE)): ImageSample {
        val lens = CameraFixtures.pinhole(64, 32)
        return fixture.headset.image(CAPTURE, roles = roles, pose = Transform.IDENTITY, intrinsics = lens)
    }

    private companion object {
        const val CAPTURE = 5_000_000_000_000
        const val DEPTH = """"depth": {"confidence": true, "flags": true}"""
        const val EXPECTED = """
            world_center world_center/image_raw sensor_msgs/msg/Image world_center image world_center_optical_frame
            world_center world_center/camera_info sensor_msgs/msg/CameraInfo sensors image world_center_optical_frame
            world_center world_center/metadata std_msgs/msg/String sensors image world_center_optical_frame
            world_left world_left/image_raw sensor_msgs/msg/Image world_left image world_left_optical_frame
            world_left world_left/camera_info sensor_msgs/msg/CameraInfo sensors image world_left_optical_frame
            world_left world_left/metadata std_msgs/msg/String sensors image world_left_optical_frame
            world_right world_right/image_raw sensor_msgs/msg/Image world_right image world_right_optical_frame
            world_right world_right/camera_info sensor_msgs/msg/CameraInfo sensors image world_right_optical_frame
            world_right world_right/metadata std_msgs/msg/String sensors image world_right_optical_frame
            color color/image_raw/compressed sensor_msgs/msg/CompressedImage color image color_optical_frame
            color color/camera_info sensor_msgs/msg/CameraInfo sensors image color_optical_frame
            color color/metadata std_msgs/msg/String sensors image color_optical_frame
            mixed_reality mixed_reality/image_raw/compressed sensor_msgs/msg/CompressedImage mixed_reality image color_optical_frame
            mixed_reality mixed_reality/camera_info sensor_msgs/msg/CameraInfo sensors image color_optical_frame
            mixed_reality mixed_reality/metadata std_msgs/msg/String sensors image color_optical_frame
            depth depth/image_raw sensor_msgs/msg/Image depth image depth_optical_frame
            depth depth/camera_info sensor_msgs/msg/CameraInfo sensors image depth_optical_frame
            depth depth/metadata std_msgs/msg/String sensors image depth_optical_frame
            depth depth/confidence sensor_msgs/msg/Image depth image depth_optical_frame
            depth depth/flags sensor_msgs/msg/Image depth image depth_optical_frame
            infra infra/image_raw sensor_msgs/msg/Image infra image depth_optical_frame
            infra infra/camera_info sensor_msgs/msg/CameraInfo sensors image depth_optical_frame
            infra infra/metadata std_msgs/msg/String sensors image depth_optical_frame
            eye_nasal_left eye_nasal_left/image_raw sensor_msgs/msg/Image eye_nasal_left image eye_nasal_left_optical_frame
            eye_nasal_left eye_nasal_left/metadata std_msgs/msg/String sensors image eye_nasal_left_optical_frame
            eye_nasal_right eye_nasal_right/image_raw sensor_msgs/msg/Image eye_nasal_right image eye_nasal_right_optical_frame
            eye_nasal_right eye_nasal_right/metadata std_msgs/msg/String sensors image eye_nasal_right_optical_frame
            eye_temple_left eye_temple_left/image_raw sensor_msgs/msg/Image eye_temple_left image eye_temple_left_optical_frame
            eye_temple_left eye_temple_left/metadata std_msgs/msg/String sensors image eye_temple_left_optical_frame
            eye_temple_right eye_temple_right/image_raw sensor_msgs/msg/Image eye_temple_right image eye_temple_right_optical_frame
            eye_temple_right eye_temple_right/metadata std_msgs/msg/String sensors image eye_temple_right_optical_frame
            accel_left accel_left/imu sensor_msgs/msg/Imu sensors imu imu_left_frame
            accel_right accel_right/imu sensor_msgs/msg/Imu sensors imu imu_right_frame
            accel_compute_pack accel_compute_pack/imu sensor_msgs/msg/Imu sensors imu imu_compute_pack_frame
            gyro_left gyro_left/imu sensor_msgs/msg/Imu sensors imu imu_left_frame
            gyro_right gyro_right/imu sensor_msgs/msg/Imu sensors imu imu_right_frame
            gyro_compute_pack gyro_compute_pack/imu sensor_msgs/msg/Imu sensors imu imu_compute_pack_frame
            imu_left imu_left/imu sensor_msgs/msg/Imu sensors imu imu_left_frame
            imu_right imu_right/imu sensor_msgs/msg/Imu sensors imu imu_right_frame
            imu_compute_pack imu_compute_pack/imu sensor_msgs/msg/Imu sensors imu imu_compute_pack_frame
            light_sensor light_sensor sensor_msgs/msg/Illuminance sensors sensor head_frame
            head_pose head_pose geometry_msgs/msg/PoseStamped sensors sensor magicleap_world
            magnetometer_left magnetometer_left sensor_msgs/msg/MagneticField sensors sensor imu_left_frame
            magnetometer_right magnetometer_right sensor_msgs/msg/MagneticField sensors sensor imu_right_frame
            pressure_headset pressure_headset sensor_msgs/msg/FluidPressure sensors sensor head_frame
            pressure_compute_pack pressure_compute_pack sensor_msgs/msg/FluidPressure sensors sensor imu_compute_pack_frame
            gaze gaze geometry_msgs/msg/PoseStamped sensors sensor magicleap_world
            hand_left hand_left geometry_msgs/msg/PoseArray sensors sensor magicleap_world
            hand_right hand_right geometry_msgs/msg/PoseArray sensors sensor magicleap_world
            battery battery sensor_msgs/msg/BatteryState sensors sensor head_frame
            tf /tf tf2_msgs/msg/TFMessage sensors tf magicleap_world
            controller controller geometry_msgs/msg/PoseStamped sensors sensor magicleap_world
            controller_joy controller/joy sensor_msgs/msg/Joy sensors sensor controller_frame
            markers markers vision_msgs/msg/Detection3DArray sensors sensor magicleap_world
            map map/state diagnostic_msgs/msg/DiagnosticArray sensors sensor magicleap_map"""
    }
}
