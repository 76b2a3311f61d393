package dev.ml2sensors.simulator.replay

import dev.ml2sensors.message.Transform
import dev.ml2sensors.source.ImageSample
import dev.ml2sensors.source.PoseSample
import dev.ml2sensors.source.Sample
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.source.VectorSample
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable
import kotlinx.coroutines.test.runTest
import org.junit.jupiter.api.Assumptions.assumeTrue
import org.junit.jupiter.api.BeforeEach
import java.io.File
import kotlin.test.Test
import kotlin.test.assertContentEquals
import kotlin.test.assertEquals
import kotlin.test.assertNotNull

/** Plays 4.7 s of the real V1_01 sequence; what it must deliver is read from the files by other means. */
class EurocExcerptTest {
    private val folder = File("../../../shared/data/euroc_v1_01_excerpt")

    @BeforeEach
    fun needsTheRecording() {
        assumeTrue(folder.isDirectory, "skipped: the EuRoC excerpt is not at ${folder.canonicalPath}")
    }

    @Test
    fun everyImageHasThePixelsAndTimeOfItsFile() = runTest {
        for ((stream, camera) in mapOf(StreamTable.worldLeft to "cam0", StreamTable.worldRight to "cam1")) {
            val rows = rows(camera)
            val captures = mutableListOf<Long>()
            collect(stream) { sample ->
                val image = sample as ImageSample
                val file = folder.resolve("mav0/$camera/data/${rows[captures.size][1]}")
                assertContentEquals(greyPixels(file), image.copy(), "$file")
                assertNotNull(image.pose)
                captures += image.captureNanos
            }
            assertEquals(95, captures.size)
            assertSteps(rows, captures)
        }
    }

    @Test
    fun everyInertialSampleHasTheValuesAndTimeOfItsRow() = runTest {
        val rows = rows("imu0")
        for ((stream, columns) in mapOf(StreamTable.gyroLeft to 1..3, StreamTable.accelLeft to 4..6)) {
            val samples = mutableListOf<VectorSample>()
            collect(stream) { samples += it as VectorSample }
            assertEquals(950, samples.size)
            assertSteps(rows, samples.map { it.captureNanos })
            val expected = rows.map { row -> columns.map { row[it].toDouble() } }
            assertEquals(expected, samples.map { listOf(it.x, it.y, it.z) })
        }
    }

    @Test
    fun everyPoseIsThatOfItsRow() = runTest {
        val rows = rows("state_groundtruth_estimate0")
        val samples = mutableListOf<PoseSample>()
        collect(StreamTable.headPose) { samples += it as PoseSample }
        assertSteps(rows, samples.map { it.captureNanos })
        assertEquals(rows.map { row -> (1..7).map { row[it].toDouble() } }, samples.map { it.pose!!.asRow() })
    }

    private suspend fun collect(stream: StreamSpec, action: (Sample) -> Unit) {
        ReplayHeadset(EurocRecording.open(folder), { 0 }, Double.POSITIVE_INFINITY)
            .samples(stream, StreamValues()).collect { action(it) }
    }

    private fun rows(sensor: String): List<List<String>> =
        folder.resolve("mav0/$sensor/data.csv").readLines().drop(1).map { it.split(",") }

    private fun assertSteps(rows: List<List<String>>, captures: List<Long>) {
        assertEquals(rows.map { it[0].toLong() }.zipWithNext { a, b -> b - a }, captures.zipWithNext { a, b -> b - a })
    }

    private fun Transform.asRow() =
        listOf(translation.x, translation.y, translation.z, rotation.w, rotation.x, rotation.y, rotation.z)
}
