package dev.ml2sensors.stream

import dev.ml2sensors.message.Quaternion
import dev.ml2sensors.message.Transform
import dev.ml2sensors.message.Vector3
import dev.ml2sensors.message.assertMatrix
import dev.ml2sensors.message.times
import dev.ml2sensors.message.toMatrix
import dev.ml2sensors.message.transform
import org.junit.jupiter.api.Test
import kotlin.math.cos
import kotlin.math.sin
import kotlin.random.Random
import kotlin.test.assertContains
import kotlin.test.assertEquals
import kotlin.test.assertNotNull
import kotlin.test.assertNull

class SensorMountingTest {
    private val mounting = SensorMounting()
    private val random = Random(3)
    private val truth = random.transform()

    @Test
    fun theFirstFrameGivesAnEstimateThatIsNotStable() {
        assertNull(mounting.add(truth))
        assertMatrix(truth.toMatrix(), mounting.latest.toMatrix())
        assertNull(mounting.stable)
    }

    @Test
    fun thirtyFramesThatAgreeAreStable() {
        repeat(29) { assertNull(mounting.add(truth)) }
        val residual = assertNotNull(mounting.add(truth))
        assertMatrix(truth.toMatrix(), assertNotNull(mounting.stable).toMatrix())
        assertEquals("median 0.000 mm and 0.0000 deg, at most 0.000 mm and 0.0000 deg", "$residual")
    }

    @Test
    fun aRotationAndItsNegationAreOne() {
        val (x, y, z, w) = truth.rotation
        val negated = truth.copy(rotation = Quaternion(-x, -y, -z, -w))
        repeat(30) { mounting.add(if (it % 2 == 0) truth else negated) }
        assertMatrix(truth.toMatrix(), assertNotNull(mounting.stable).toMatrix())
    }

    @Test
    fun aFewWrongFramesMoveNothingAndAreInTheResidual() {
        var residual: SensorMounting.Residual? = null
        repeat(30) { residual = mounting.add(if (it % 10 == 5) truth * off(0.02, 0.0) else truth) }
        assertMatrix(truth.toMatrix(), assertNotNull(mounting.stable).toMatrix())
        assertContains("$residual", "at most 20.000 mm")
    }

    @Test
    fun aTenthThatIsTooFarAwayIsNotStable() {
        repeat(30) { mounting.add(if (it % 7 == 0) truth * off(0.0011, 0.0) else truth) }
        assertNull(mounting.stable)
    }

    @Test
    fun rotationsThatDisagreeAreNotStable() {
        repeat(60) { mounting.add(truth * off(0.0, if (it % 2 == 0) 0.0 else 0.3)) }
        assertNull(mounting.stable)
    }

    @Test
    fun whatIsStableStaysUntilItHasMovedByMoreThanItsSpread() {
        repeat(30) { mounting.add(truth) }
        repeat(60) { assertNull(mounting.add(truth * off(0.0005, 0.05))) }
        assertMatrix(truth.toMatrix(), mounting.latest.toMatrix())
        val moved = truth * off(0.005, 0.0)
        val changes = (0 until 60).mapNotNull { mounting.add(moved) }
        assertEquals(1, changes.size)
        assertMatrix(moved.toMatrix(), assertNotNull(mounting.stable).toMatrix())
    }

    private fun off(metres: Double, degrees: Double): Transform {
        val half = Math.toRadians(degrees) / 2
        return Transform(Vector3(metres, 0.0, 0.0), Quaternion(0.0, 0.0, sin(half), cos(half)))
    }
}
