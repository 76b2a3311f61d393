package dev.ml2sensors.simulator.replay

import dev.ml2sensors.message.Quaternion
import dev.ml2sensors.message.Transform
import dev.ml2sensors.message.Vector3
import dev.ml2sensors.source.Distortion
import org.junit.jupiter.api.DynamicTest
import org.junit.jupiter.api.DynamicTest.dynamicTest
import org.junit.jupiter.api.TestFactory
import org.junit.jupiter.api.io.TempDir
import java.awt.image.BufferedImage
import java.io.File
import java.nio.file.Files
import kotlin.test.Test
import kotlin.test.assertEquals
import kotlin.test.assertFailsWith
import kotlin.test.assertNotNull
import kotlin.test.assertNull
import kotlin.test.assertTrue

/** Data sets that deviate from EuRoC's own files, as other programs write them. */
class ForeignRecordingTest {
    @TempDir
    lateinit var folder: File

    private val files by lazy { SyntheticRecording(folder) }

    @TestFactory
    fun deviationThatChangesNothingIsReadAsTheOriginal(): List<DynamicTest> = listOf<Pair<String, (File) -> Unit>>(
        "header without #" to { it.edit("imu0/data.csv") { text -> text.removePrefix("#") } },
        "header without # after a comment" to { it.edit(TRUTH) { text -> "# by hand\n" + text.removePrefix("#") } },
        "trailing commas" to { it.edit("imu0/data.csv") { text -> text.replace("\r\n", ",,\r\n") } },
        "trailing commas of images" to { it.edit("cam0/data.csv") { text -> text.replace("\r\n", ",\r\n") } },
        "byte order mark" to { it.edit("cam0/data.csv") { text -> "\uFEFF$text" } },
        "byte order mark before a header without #" to { it.edit(TRUTH) { text -> "\uFEFF" + text.removePrefix("#") } },
        "byte order mark in YAML" to { it.edit(YAML) { text -> "\uFEFF$text" } },
        "line feeds" to { it.edit("imu0/data.csv") { text -> text.replace("\r\n", "\n") } },
        "carriage returns" to { it.edit("imu0/data.csv") { text -> text.replace("\r\n", "\r") } },
        "no line end at the end" to { it.edit("cam0/data.csv") { text -> text.trimEnd() } },
        "empty lines" to { it.edit("cam0/data.csv") { text -> text.replace("\r\n", "\r\n\r\n") } },
        "spaces behind commas" to { it.edit(TRUTH) { text -> text.replace(",", ", ") } },
        "semicolons" to { it.edit(TRUTH) { text -> text.replace(",", ";") } },
        "tabs" to { it.edit("imu0/data.csv") { text -> text.replace(",", "\t") } },
        "blanks" to { it.edit("cam0/data.csv") { text -> text.replace(",", "  ") } },
        "images with their folder" to { it.edit("cam0/data.csv") { text -> text.replace(",1", ",cam0/data/1") } },
        "images without their ending" to { it.edit("cam0/data.csv") { text -> text.replace(".png", "") } },
        "eight columns of ground truth" to { it.edit(TRUTH) { text -> text.columns(8) } },
        "eleven columns of ground truth" to { it.edit(TRUTH) { text -> text.columns(11) } },
        "quotes around all fields" to {
            it.edit("cam0/data.csv") { text -> text.replace(Regex("[^,\r\n]+"), "\"$0\"") }
        },
        "a header of fewer columns" to { it.edit(TRUTH) { text -> text.replaceBefore("\r\n", "timestamp,pose") } },
        "more columns of an IMU" to { it.edit("imu0/data.csv") { text -> text.replace("\r\n", ",36.6\r\n") } },
        "times with a decimal point" to { it.edit("imu0/data.csv") { text -> text.replaceFirst(FIRST, "$FIRST.0") } },
        "rate with a decimal point" to { it.edit(YAML) { text -> text.replace("rate_hz: 20", "rate_hz: 20.0") } },
        "rate that is not whole" to { it.edit(YAML) { text -> text.replace("rate_hz: 20", "rate_hz: 19.97") } },
        "no rate" to { it.edit(YAML) { text -> text.replace("rate_hz: 20", "") } },
        "five coefficients" to { it.edit(YAML) { text -> text.replace("e-05]", "e-05, 0.0]") } },
        "eight coefficients, the last ones 0" to
            { it.edit(YAML) { text -> text.replace("e-05]", "e-05, 0, 0, 0, 0]") } },
        "radtan" to { it.edit(YAML) { text -> text.replace("radial-tangential", "radtan") } },
        "Pinhole" to { it.edit(YAML) { text -> text.replace("pinhole", "Pinhole") } },
        "T_BS as a list of rows" to { it.edit(YAML) { text -> text.matrix("T_BS: [[$ROWS]]") } },
        "T_BS.data as a list of rows" to { it.edit(YAML) { text -> text.matrix("T_BS: {data: [[$ROWS]]}") } },
        "T_BS of OpenCV" to { it.edit(YAML) { text -> text.replace("T_BS:", "T_BS: !!opencv-matrix") } },
        "negative zeros" to { it.edit(YAML) { text -> text.replace("0.0, 0.0, 0.0, 1.0]", "-0.0, -0.0, 0.0, 1.0]") } },
        "ground truth in gt" to { it.resolve("state_groundtruth_estimate0").renameTo(it.resolve("gt")) },
        "ground truth in mocap0" to { it.resolve("state_groundtruth_estimate0").renameTo(it.resolve("mocap0")) },
    ).map { (name, deviate) ->
        dynamicTest(name) {
            val foreign = SyntheticRecording(Files.createTempDirectory(folder.toPath(), "foreign").toFile())
            deviate(foreign.folder.resolve("mav0"))
            val recording = foreign.open()
            assertEquals(summary(files.open()), summary(recording))
            assertEquals(emptyList(), recording.notes)
        }
    }

    @Test
    fun quaternionsOfThreeDigitsAreUnits() {
        files.replace(TRUTH, "1,0,0,0", "0.577,0.577,0.577,0.0")
        val (x, y, z, w) = assertNotNull(files.open().groundTruth).poses.first().rotation
        assertEquals(1.0, x * x + y * y + z * z + w * w, 1e-9)
    }

    @Test
    fun timesInMicrosecondsAreNotTakenForNanoseconds() {
        // The name of the file stays
        files.file("cam0/data.csv").edit { it.replace(Regex("(?m)^(\\d+)\\d{3},"), "$1,") }
        val failure = assertFailsWith<RecordingException> { files.open() }
        assertEquals("times in ns, 50000000 apart by rate_hz 20" to "50001 apart", failure.expected to failure.found)
    }

    @Test
    fun mav0ItselfIsTheDataSet() {
        val recording = EurocRecording.open(files.folder.resolve("mav0"))
        assertEquals(summary(files.open()), summary(recording))
        assertEquals(folder.name, recording.name)
    }

    @Test
    fun dataSetWithoutTheLeftCameraHasTheRightOne() {
        files.file("cam0").deleteRecursively()
        val recording = files.open()
        assertNull(recording.left)
        assertEquals(SyntheticRecording.IMAGES, recording.right?.images?.size)
    }

    @Test
    fun fifthCoefficientIsTheThirdRadialOne() {
        files.replace("cam0/sensor.yaml", "e-05]", "e-05, 0.25]")
        assertEquals(0.25, (files.open().left?.intrinsics?.distortion as Distortion.PlumbBob).k3)
    }

    @Test
    fun equidistantLensIsRead() {
        files.replace("cam0/sensor.yaml", "radial-tangential", "equidistant")
        val lens = Distortion.Equidistant(-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05)
        assertEquals(lens, files.open().left?.intrinsics?.distortion)
    }

    @Test
    fun imagesWithoutAFileAreLeftOutAndCounted() {
        files.file("cam0/data/${SyntheticRecording.stamp(1)}.png").delete()
        val recording = files.open()
        assertEquals(listOf(0, 2).map(SyntheticRecording::stamp), recording.left?.images?.map { it.stampNanos })
        val note = recording.notes.single()
        assertTrue("cam0/data.csv:3: no file" in note && note.endsWith("images left out: 1 of 3"), note)
    }

    @Test
    fun cameraWithoutAnyFileIsRefused() {
        files.file("cam0/data").deleteRecursively()
        val failure = assertFailsWith<RecordingException> { files.open() }
        assertEquals(2, failure.line)
        assertTrue("data/$FIRST.png" in failure.expected, failure.message)
    }

    @Test
    fun filesWithoutARowAreCounted() {
        files.file("cam0/data.csv").edit { it.lines().dropLast(2).joinToString("\n") }
        val recording = files.open()
        assertEquals(2, recording.left?.images?.size)
        assertTrue(recording.notes.single().endsWith("no row in data.csv: 1"), "${recording.notes}")
    }

    @Test
    fun lastLineThatEndsTooEarlyIsLeftOutAndSaid() {
        files.file("imu0/data.csv").edit { it.dropLast(12) }
        val recording = files.open()
        assertEquals(9, recording.imu?.stamps?.size)
        assertTrue("imu0/data.csv:11: the last line ends too early" in recording.notes.single(), "${recording.notes}")
    }

    @Test
    fun otherSensorsAreNamedAsNotReplayed() {
        for (other in listOf("leica0", "cam2", "mocap0")) {
            files.file("imu0").copyRecursively(files.file(other))
        }
        val note = files.open().notes.single()
        assertTrue(note.endsWith("not replayed: cam2, leica0, mocap0"), note)
    }

    @Test
    fun tumViHasItsCalibrationInKalibrsFile() {
        calibrateBy("dso/camchain.yaml", CAMCHAIN)
        val camera = assertNotNull(files.open().left)
        assertEquals(Distortion.Equidistant(0.0034, 0.0007, -0.0021, 0.0003), camera.intrinsics.distortion)
        assertEquals(listOf(190.97, 190.98, 254.93, 256.89), camera.intrinsics.run { listOf(fx, fy, cx, cy) })
        assertEquals(20, camera.rateHz)
        // T_cam_imu turns by 90 degrees about z and moves by (1, 2, 3); this is its inverse
        val (x, y, z) = camera.inBody.translation
        listOf(-2.0, 1.0, -3.0).zip(listOf(x, y, z)).forEach { (expected, found) ->
            assertEquals(expected, found, 1e-9)
        }
        assertClose(Quaternion(0.0, 0.0, -HALF, HALF), camera.inBody.rotation)
    }

    @Test
    fun monadoHasItsCalibrationInBasaltsFile() {
        calibrateBy("calibration.json", CALIBRATION)
        val recording = files.open()
        val left = assertNotNull(recording.left)
        assertEquals(Distortion.Equidistant(0.1, 0.2, 0.3, 0.4), left.intrinsics.distortion)
        assertEquals(Transform(Vector3(1.0, 2.0, 3.0), Quaternion(0.0, 0.0, 0.6, 0.8)), left.inBody)
        assertEquals(Distortion.PlumbBob(0.1, 0.2, 0.3, 0.4, 0.5), recording.right?.intrinsics?.distortion)
    }

    @Test
    fun lensOfBasaltThatRosHasNotIsRefused() {
        calibrateBy("calibration.json", CALIBRATION.replace("\"k6\": 0", "\"k6\": 0.5"))
        val failure = assertFailsWith<RecordingException> { files.open() }
        assertEquals(folder.resolve("calibration.json"), failure.file)
        assertTrue("the others 0" in failure.expected, failure.message)
    }

    @Test
    fun cameraWithoutCalibrationIsToldWhichFilesWouldDo() {
        files.file("cam0/sensor.yaml").delete()
        val failure = assertFailsWith<RecordingException> { files.open() }
        for (name in listOf("sensor.yaml", "camchain.yaml", "calibration.json")) {
            assertTrue(name in failure.message.orEmpty(), failure.message)
        }
    }

    @Test
    fun imagesOfOtherFormatsAreSaidOnce() {
        for (image in 0 until SyntheticRecording.IMAGES) {
            val file = files.file("cam0/data/${SyntheticRecording.stamp(image)}.png")
            SyntheticRecording.writePng(file, SyntheticRecording.pixels(image), type = BufferedImage.TYPE_USHORT_GRAY)
        }
        assertEquals(listOf("cam0: images of 16-bit grey are converted to 8-bit grey"), files.open().notes)
    }

    @Test
    fun imagesOfAnotherSizeAreRefusedAtOnce() {
        files.replace("cam0/sensor.yaml", "[5, 3]", "[5, 4]")
        val failure = assertFailsWith<RecordingException> { files.open() }
        assertEquals(files.file("cam0/data/$FIRST.png"), failure.file)
        assertEquals("5x4 pixels" to "5x3", failure.expected to failure.found)
    }

    private fun calibrateBy(name: String, text: String) {
        for (camera in listOf("cam0", "cam1")) files.file("$camera/sensor.yaml").delete()
        folder.resolve(name).run {
            parentFile.mkdirs()
            writeText(text)
        }
    }

    /** All that was read, but for the paths. */
    private fun summary(recording: EurocRecording): List<Any?> =
        listOf(recording.left, recording.right).flatMap { camera ->
            listOf(
                camera?.images?.map {
                    it.stampNanos to it.file.name
                },
                camera?.rateHz,
                camera?.intrinsics,
                camera?.inBody,
            )
        } + listOf(
            recording.imu?.stamps?.toList(),
            recording.imu?.gyro?.map { it.toList() },
            recording.imu?.accel?.map { it.toList() },
            recording.groundTruth?.stamps?.toList(),
            recording.groundTruth?.poses,
        )

    private fun File.edit(path: String, change: (String) -> String) = resolve(path).edit(change)

    private fun File.edit(change: (String) -> String) = writeText(change(readText()))

    private fun String.columns(count: Int) =
        lines().joinToString("\r\n") { it.split(',').take(count).joinToString(",") }

    private fun String.matrix(replacement: String) = replace(
        Regex("T_BS:.*?]", RegexOption.DOT_MATCHES_ALL),
        replacement,
    )

    private companion object {
        const val TRUTH = "state_groundtruth_estimate0/data.csv"
        const val YAML = "cam0/sensor.yaml"
        const val FIRST = "${SyntheticRecording.FIRST}"
        const val HALF = 0.7071067811865476

        /** T_BS of the synthetic recording. */
        const val ROWS = "0, -1, 0, 0.25], [1, 0, 0, -0.5], [0, 0, 1, 2], [0, 0, 0, 1"

        val CAMCHAIN = """
            cam0: &camera
              T_cam_imu:
              - [0.0, -1.0, 0.0, 1.0]
              - [1.0, 0.0, 0.0, 2.0]
              - [0.0, 0.0, 1.0, 3.0]
              - [0.0, 0.0, 0.0, 1.0]
              camera_model: pinhole
              distortion_coeffs: [0.0034, 0.0007, -0.0021, 0.0003]
              distortion_model: equidistant
              intrinsics: [190.97, 190.98, 254.93, 256.89]
              resolution: [5, 3]
              rostopic: /cam0/image_raw
            cam1: *camera
        """.trimIndent()

        val CALIBRATION = """
            {"value0": {
              "T_imu_cam": [
                {"px": 1, "py": 2, "pz": 3, "qx": 0, "qy": 0, "qz": 0.6, "qw": 0.8},
                {"px": 0, "py": 0, "pz": 0, "qx": 0, "qy": 0, "qz": 0, "qw": 1}
              ],
              "intrinsics": [
                {"camera_type": "kb4", "intrinsics":
                  {"fx": 4, "fy": 4, "cx": 2, "cy": 1, "k1": 0.1, "k2": 0.2, "k3": 0.3, "k4": 0.4}},
                {"camera_type": "pinhole-radtan8", "intrinsics":
                  {"fx": 4, "fy": 4, "cx": 2, "cy": 1, "k1": 0.1, "k2": 0.2, "p1": 0.3, "p2": 0.4,
                   "k3": 0.5, "k4": 0, "k5": 0, "k6": 0, "rpmax": 2.7}}
              ],
              "resolution": [[5, 3], [5, 3]]
            }}
        """.trimIndent()
    }
}
