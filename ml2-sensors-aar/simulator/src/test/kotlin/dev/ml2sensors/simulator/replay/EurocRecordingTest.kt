package dev.ml2sensors.simulator.replay

import dev.ml2sensors.message.Quaternion
import dev.ml2sensors.message.Transform
import dev.ml2sensors.message.Vector3
import dev.ml2sensors.source.Distortion
import dev.ml2sensors.source.Intrinsics
import org.junit.jupiter.api.DynamicTest
import org.junit.jupiter.api.DynamicTest.dynamicTest
import org.junit.jupiter.api.TestFactory
import org.junit.jupiter.api.io.TempDir
import java.io.File
import java.nio.file.Files
import kotlin.math.sqrt
import kotlin.random.Random
import kotlin.test.Test
import kotlin.test.assertContentEquals
import kotlin.test.assertEquals
import kotlin.test.assertFailsWith
import kotlin.test.assertNotNull
import kotlin.test.assertNull
import kotlin.test.assertTrue

class EurocRecordingTest {
    @TempDir
    lateinit var folder: File

    @Test
    fun rowsAndCalibrationAreThoseOfTheFiles() {
        val recording = SyntheticRecording(folder).open()
        val camera = assertNotNull(recording.left)
        assertEquals(List(3, SyntheticRecording::stamp), camera.images.map { it.stampNanos })
        assertEquals(20, camera.rateHz)
        val distortion = Distortion.PlumbBob(-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05, 0.0)
        assertEquals(Intrinsics(5, 3, 458.654, 457.296, 367.215, 248.375, distortion), camera.intrinsics)
        val half = sqrt(0.5)
        assertEquals(Vector3(0.25, -0.5, 2.0), camera.inBody.translation)
        assertClose(Quaternion(0.0, 0.0, half, half), camera.inBody.rotation)
        assertContentEquals(doubleArrayOf(0.3, -1.0, 2e-3), recording.imu?.gyro?.get(3))
        assertContentEquals(doubleArrayOf(9.83, 0.0, -0.3), recording.imu?.accel?.get(3))
        val pose = Transform(Vector3(1.0, 2.0, 3.0), Quaternion(0.6, 0.0, 0.0, 0.8))
        assertEquals(pose, recording.groundTruth?.poses?.get(1))
        assertEquals(folder.name, recording.name)
    }

    @Test
    fun missingFolderMeansAMissingSensor() {
        val files = SyntheticRecording(folder)
        listOf("cam1", "imu0", "state_groundtruth_estimate0").forEach { files.file(it).deleteRecursively() }
        val recording = files.open()
        assertNotNull(recording.left)
        assertNull(recording.right)
        assertNull(recording.imu)
        assertNull(recording.groundTruth)
    }

    @Test
    fun folderWithoutAnySensorIsNoRecording() {
        val failure = assertFailsWith<RecordingException> { EurocRecording.open(folder) }
        assertEquals(folder, failure.file)
        assertEquals("none of them", failure.found)
    }

    @Test
    fun folderAboveTheDataSetIsToldWhereItIs() {
        SyntheticRecording(folder.resolve("room1"))
        val failure = assertFailsWith<RecordingException> { EurocRecording.open(folder) }
        assertEquals("none of them; there is one in room1", failure.found)
    }

    @TestFactory
    fun damagedFileIsNamedWithLineExpectedAndFound(): List<DynamicTest> = listOf(
        Damage("cam0/data.csv", ",$SECOND.png", "", 3, "2 columns", "1"),
        Damage("cam0/data.csv", "$SECOND,", "1.5,", 3, "integer nanoseconds", "1.5"),
        Damage("cam0/data.csv", "$SECOND,", "99999999999999999999,", 3, "nanoseconds", "9999"),
        Damage("cam0/data.csv", "$SECOND,", "${SyntheticRecording.FIRST},", 3, "time after", "1403"),
        Damage("imu0/data.csv", "2e-3", "nan", 2, "finite number", "nan"),
        Damage("imu0/data.csv", "2e-3", "NaN", 2, "finite number", "NaN"),
        Damage("imu0/data.csv", "2e-3", "1e999", 2, "finite number", "1e999"),
        Damage("imu0/data.csv", ",9.80,0,-0.0", "", 2, "7 columns", "4"),
        Damage("imu0/data.csv", "#timestamp", "1,x\n#timestamp", 1, "7 columns", "2"),
        Damage("imu0/data.csv", "0.1,-1,2e-3", "x,-1,2e-3", 3, "finite number", "x"),
        Damage(TRUTH, ",1,2,3,0.8,0.6,0,0,0,0,0,0,0,0,0,0,0", ",1,2,3,0.8,0.6,0", 3, "8 columns", "7"),
        Damage(TRUTH, "0.8,0.6,0,0", "0.8,0.6,1,0", 3, "unit quaternion", "0.8,0.6"),
        Damage(CAM1, "  data: [", "  data: ]", 6, "YAML", "but found ']'"),
        Damage(CAM1, "T_BS:", "T_SB:", null, "T_BS to be present", "nothing"),
        Damage(CAM1, "0.0, 0.0, 0.0, 1.0]", "0.0, 0.0, 0.0]", 6, "16 numbers", "15"),
        Damage(CAM1, "0.0, 0.0, 0.0, 1.0]", "0.0, 0.0, 1.0, 1.0]", 6, "rigid transform", "1.0, 1.0"),
        Damage(CAM1, "[0.0, -1.0,", "[0.0, 1.0,", 6, "rigid transform", "[0.0, 1.0"),
        Damage(CAM1, "[0.0, -1.0,", "[0.0, -1e300,", 6, "rigid transform", "-1.0E300"),
        Damage(CAM1, "rate_hz: 20", "rate_hz: 0", 10, "rate_hz to be positive", "0"),
        Damage(CAM1, "rate_hz: 20", "rate_hz: fast", 10, "rate_hz to be a finite number", "'fast'"),
        Damage(CAM1, "rate_hz: 20", "rate_hz: [20]", 10, "rate_hz to be a finite number", "a collection"),
        Damage(CAM1, "[5, 3]", "[0, 3]", 11, "resolution to be integers of 1 to 4095", "[0.0, 3.0]"),
        Damage(CAM1, "[5, 3]", "[5, 65536]", 11, "integers of 1 to 4095", "65536"),
        Damage(CAM1, "[5, 3]", "[5, 2.5]", 11, "integers of 1 to 4095", "2.5"),
        Damage(CAM1, "[5, 3]", "{a: 3}", 11, "list of numbers", "something else"),
        Damage(CAM1, "457.296", "x", 13, "a finite number", "'x'"),
        Damage(CAM1, "pinhole", "omni", 12, "camera_model to be pinhole", "'omni'"),
        Damage(CAM1, "radial-tangential", "fov", 14, "radial-tangential, equidistant or none", "'fov'"),
        Damage(CAM1, "0.00019359, ", "", 15, "distortion_coefficients to be k1, k2, p1, p2", "-0.28340811"),
        Damage(CAM1, ", 1.76187114e-05]", ", 1e-5, 0, 0.1]", 15, "if any, k3 (the others 0)", "0.1"),
    ).map { damage ->
        dynamicTest("${damage.path}: ${damage.old} -> ${damage.new}") {
            val files = SyntheticRecording(Files.createTempDirectory(folder.toPath(), "damaged").toFile())
            files.replace(damage.path, damage.old, damage.new)
            val failure = assertFailsWith<RecordingException> { files.open() }
            assertEquals(files.file(damage.path), failure.file)
            assertEquals(damage.line, failure.line)
            assertTrue(damage.expected in failure.expected, failure.message)
            assertTrue(damage.found in failure.found, failure.message)
        }
    }

    private companion object {
        const val CAM1 = "cam1/sensor.yaml"
        const val TRUTH = "state_groundtruth_estimate0/data.csv"
        val SECOND = SyntheticRecording.stamp(1)
    }

    private class Damage(
        val path: String,
        val old: String,
        val new: String,
        val line: Int?,
        val expected: String,
        val found: String,
    )

    @Test
    fun absentOrEmptyFilesAreNamed() {
        val files = SyntheticRecording(folder)
        for (path in listOf("cam0/data.csv", "cam0/sensor.yaml", "imu0/data.csv")) {
            val original = files.file(path).readText()
            for (damage in listOf<(File) -> Unit>({ it.delete() }, { it.writeText("# only this\n") })) {
                damage(files.file(path))
                assertEquals(files.file(path), assertFailsWith<RecordingException> { files.open() }.file)
            }
            files.file(path).writeText(original)
        }
        files.open()
    }

    @Test
    fun randomDamageGivesARecordingOrARecordingException() {
        val files = SyntheticRecording(folder)
        val random = Random(20260101)
        val paths = listOf("cam0/data.csv", "cam0/sensor.yaml", "imu0/data.csv", TRUTH)
        var failures = 0
        repeat(2000) {
            val file = files.file(paths.random(random))
            val original = file.readBytes()
            val bytes = original.copyOf(if (random.nextInt(4) == 0) random.nextInt(original.size) else original.size)
            if (bytes.isNotEmpty()) {
                repeat(random.nextInt(1, 4)) { bytes[random.nextInt(bytes.size)] = random.nextBytes(1)[0] }
            }
            file.writeBytes(bytes)
            try {
                files.open()
            } catch (failure: RecordingException) {
                failures++
                assertEquals(file, failure.file)
            }
            file.writeBytes(original)
        }
        assertTrue(failures in 500..1999, "$failures")
    }
}
