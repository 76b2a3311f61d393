package dev.ml2sensors.message

import org.junit.jupiter.api.Test
import kotlin.math.PI
import kotlin.math.cos
import kotlin.math.sin
import kotlin.random.Random
import kotlin.test.assertEquals
import kotlin.test.assertFailsWith

class TransformsTest {
    private val random = Random(2)

    /** A quarter turn to the left, seen from above. */
    private val left = Quaternion(0.0, 0.0, HALF, HALF)

    @Test
    fun aQuarterTurnAboutZTakesXToY() {
        assertVector(Vector3(0.0, 1.0, 0.0), left.rotate(Vector3(1.0, 0.0, 0.0)))
        assertVector(Vector3(-1.0, 0.0, 0.0), left.rotate(Vector3(0.0, 1.0, 0.0)))
        assertVector(Vector3(0.0, 0.0, 1.0), left.rotate(Vector3(0.0, 0.0, 1.0)))
    }

    @Test
    fun aChildIsPlacedByTheRotationAndThenTheTranslationOfItsParent() {
        val parent = Transform(Vector3(10.0, 0.0, 0.0), left)
        val child = Transform(Vector3(1.0, 0.0, 2.0), left)
        val placed = parent * child
        assertVector(Vector3(10.0, 1.0, 2.0), placed.translation)
        assertRotation(Quaternion(0.0, 0.0, 1.0, 0.0), placed.rotation)
    }

    @Test
    fun compositionIsTheProductOfMatrices() {
        repeat(100) {
            val a = random.transform()
            val b = random.transform()
            assertMatrix(a.toMatrix() * b.toMatrix(), (a * b).toMatrix())
        }
    }

    @Test
    fun pointsAreMappedAsByTheMatrix() {
        repeat(100) {
            val transform = random.transform()
            val point = random.vector()
            val mapped = transform.toMatrix() * Transform(point, Quaternion.IDENTITY).toMatrix()
            assertVector(Vector3(mapped[0, 3], mapped[1, 3], mapped[2, 3]), transform.map(point))
        }
    }

    @Test
    fun aTransformAndItsInverseCancel() {
        repeat(100) {
            val transform = random.transform()
            assertMatrix(Transform.IDENTITY.toMatrix(), (transform * transform.inverse()).toMatrix())
            assertMatrix(Transform.IDENTITY.toMatrix(), transform.inverse().toMatrix() * transform.toMatrix())
        }
    }

    @Test
    fun slerpTurnsInProportionToTheFraction() {
        for (degrees in listOf(0.0, 1e-9, 1e-3, 1.0, 90.0, 179.0)) {
            for (fraction in listOf(0.0, 0.25, 0.5, 1.0)) {
                val part = Quaternion.IDENTITY.slerp(aboutX(degrees), fraction)
                assertRotation(aboutX(degrees * fraction), part)
            }
        }
    }

    @Test
    fun slerpTakesTheShorterWayWhateverTheSign() {
        val (x, y, z, w) = aboutX(60.0)
        assertRotation(aboutX(15.0), Quaternion.IDENTITY.slerp(Quaternion(-x, -y, -z, -w), 0.25))
    }

    private fun aboutX(degrees: Double) = Quaternion(sin(degrees * PI / 360), 0.0, 0.0, cos(degrees * PI / 360))

    @Test
    fun interpolationEndsAtItsEndsAndIsStraightBetween() {
        val a = random.transform()
        val b = random.transform()
        assertMatrix(a.toMatrix(), a.interpolate(b, 0.0).toMatrix())
        assertMatrix(b.toMatrix(), a.interpolate(b, 1.0).toMatrix())
        val middle = a.interpolate(b, 0.5)
        assertEquals((a.translation.x + b.translation.x) / 2, middle.translation.x, 1e-12)
        assertRotation(a.rotation.inverse() * middle.rotation, middle.rotation.inverse() * b.rotation)
    }

    @Test
    fun interpolationDoesNotExtrapolate() {
        for (fraction in listOf(-0.01, 1.01, Double.NaN)) {
            assertFailsWith<IllegalArgumentException> { Transform.IDENTITY.interpolate(Transform.IDENTITY, fraction) }
        }
    }

    @Test
    fun zeroAndNotFiniteQuaternionsAreNoRotations() {
        assertFailsWith<IllegalArgumentException> { Quaternion(0.0, 0.0, 0.0, 0.0).normalized() }
        assertFailsWith<IllegalArgumentException> { Quaternion(0.0, Double.NaN, 0.0, 1.0).normalized() }
        assertEquals(Quaternion(0.0, 0.6, 0.0, -0.8), Quaternion(0.0, 3.0, 0.0, -4.0).normalized())
    }
}
