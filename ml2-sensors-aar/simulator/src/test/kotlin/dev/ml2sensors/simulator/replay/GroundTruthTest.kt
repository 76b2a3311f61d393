package dev.ml2sensors.simulator.replay

import dev.ml2sensors.message.Quaternion
import dev.ml2sensors.message.Transform
import dev.ml2sensors.message.Vector3
import dev.ml2sensors.message.normalized
import kotlin.random.Random
import kotlin.test.Test
import kotlin.test.assertEquals
import kotlin.test.assertNotNull
import kotlin.test.assertNull

class GroundTruthTest {
    private val random = Random(7)
    private val stamps = longArrayOf(
        SyntheticRecording.FIRST,
        SyntheticRecording.FIRST + 5,
        SyntheticRecording.FIRST + 1_000_005,
    )
    private val truth = GroundTruth(stamps, List(3) { Transform(vector(), rotation()) })

    @Test
    fun poseAtARowIsThatRow() {
        stamps.forEachIndexed { row, stamp -> assertEquals(truth.poses[row], truth.poseAt(stamp)) }
    }

    @Test
    fun poseBetweenRowsIsInterpolatedLinearlyAndRotatedAboutOneAxis() {
        val (_, before, after) = truth.poses
        repeat(200) {
            val elapsed = random.nextLong(1, 1_000_000)
            val pose = assertNotNull(truth.poseAt(stamps[1] + elapsed))
            val fraction = elapsed / 1e6
            for (axis in listOf(Vector3::x, Vector3::y, Vector3::z)) {
                val expected = axis(before.translation) * (1 - fraction) + axis(after.translation) * fraction
                assertEquals(expected, axis(pose.translation), 1e-9)
            }
            val start = RotationMatrix.of(before.rotation)
            val turn = start.transposed() * RotationMatrix.of(after.rotation)
            assertMatrix(start * turn.scaled(fraction), RotationMatrix.of(pose.rotation))
        }
    }

    @Test
    fun thereIsNoPoseOutsideTheRecordedTime() {
        assertNull(truth.poseAt(stamps.first() - 1))
        assertNull(truth.poseAt(stamps.last() + 1))
        assertNull(truth.poseAt(Long.MIN_VALUE))
        assertNull(truth.poseAt(Long.MAX_VALUE))
    }

    private fun assertMatrix(expected: RotationMatrix, actual: RotationMatrix) {
        for (row in 0..2) for (column in 0..2) assertEquals(expected[row, column], actual[row, column], 1e-9)
    }

    private fun vector() = Vector3(random.nextDouble(), random.nextDouble(), random.nextDouble())

    private fun rotation() = vector().let { Quaternion(it.x, -it.y, it.z, 1.0).normalized() }
}
