package dev.ml2sensors.message

import org.junit.jupiter.api.Test
import kotlin.random.Random

class AxesTest {
    /** Axes of the headset (x right, y up, z backward) to REP-103 (x forward, y left, z up). */
    private val c = Matrix.rotation(0, 0, -1, -1, 0, 0, 0, 1, 0)

    /** Axes of a camera as the headset has them to optical ones (x right, y down, z forward). */
    private val d = Matrix.rotation(1, 0, 0, 0, -1, 0, 0, 0, -1)

    @Test
    fun aHeadsetLookingAheadLooksAlongXInRos() {
        val body = MlPose(Vector3(1.0, 2.0, 3.0), Quaternion.IDENTITY).toBody()
        assertVector(Vector3(-3.0, -1.0, 2.0), body.translation)
        assertRotation(Quaternion.IDENTITY, body.rotation)
    }

    @Test
    fun turningLeftIsAboutUpInBoth() {
        val body = MlPose(Vector3.ZERO, Quaternion(0.0, HALF, 0.0, HALF)).toBody()
        assertRotation(Quaternion(0.0, 0.0, HALF, HALF), body.rotation)
    }

    @Test
    fun lookingUpIsAboutRightInOneAndAboutMinusLeftInTheOther() {
        val body = MlPose(Vector3.ZERO, Quaternion(HALF, 0.0, 0.0, HALF)).toBody()
        assertRotation(Quaternion(0.0, -HALF, 0.0, HALF), body.rotation)
        assertVector(Vector3(0.0, 0.0, 1.0), body.rotation.rotate(Vector3(1.0, 0.0, 0.0)))
    }

    @Test
    fun anOpticalFrameHasZForwardXRightAndYDown() {
        assertVector(Vector3(1.0, 0.0, 0.0), OPTICAL_IN_BODY.map(Vector3(0.0, 0.0, 1.0)))
        assertVector(Vector3(0.0, -1.0, 0.0), OPTICAL_IN_BODY.map(Vector3(1.0, 0.0, 0.0)))
        assertVector(Vector3(0.0, 0.0, -1.0), OPTICAL_IN_BODY.map(Vector3(0.0, 1.0, 0.0)))
        assertMatrix(c * d, OPTICAL_IN_BODY.toMatrix())
    }

    @Test
    fun bodyAndOpticalPosesAreThoseOfTheMatrices() {
        val random = Random(3)
        repeat(100) {
            val position = random.vector()
            val rotation = random.quaternion()
            val ml = Transform(position, rotation).toMatrix()
            assertMatrix(c * ml * c.transposed(), MlPose(position, rotation).toBody().toMatrix())
            val pose = MlPose(position, rotation)
            assertMatrix(c * ml * d, pose.toOptical().toMatrix())
            assertMatrix(c * ml, pose.toMarker().toMatrix())
            assertVector(position, MlPose.ofOptical(pose.toOptical()).position)
            assertRotation(rotation.normalized(), MlPose.ofOptical(pose.toOptical()).rotation)
            assertRotation(rotation.normalized(), MlPose.ofBody(pose.toBody()).rotation)
        }
    }

    @Test
    fun rotationsComeOutNormalised() {
        val pose = MlPose(Vector3.ZERO, Quaternion(0.0, 0.0, 0.0, 2.0))
        assertRotation(Quaternion.IDENTITY, pose.toBody().rotation)
        assertRotation(OPTICAL_IN_BODY.rotation, pose.toOptical().rotation)
    }
}
