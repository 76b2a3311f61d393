package dev.ml2sensors.capture

import dev.ml2sensors.message.Pose
import dev.ml2sensors.message.Vector3
import dev.ml2sensors.message.rotate
import dev.ml2sensors.source.Condition
import dev.ml2sensors.source.InputSample
import dev.ml2sensors.source.PoseSample
import dev.ml2sensors.source.PosesSample
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable
import kotlinx.coroutines.flow.Flow
import kotlinx.coroutines.flow.dropWhile
import kotlinx.coroutines.flow.filterIsInstance
import kotlinx.coroutines.flow.first
import kotlinx.coroutines.flow.map
import kotlinx.coroutines.flow.take
import kotlinx.coroutines.flow.toList
import kotlinx.coroutines.runBlocking
import org.junit.jupiter.api.AfterEach
import org.junit.jupiter.api.Test
import kotlin.math.hypot
import kotlin.test.assertEquals
import kotlin.test.assertFailsWith
import kotlin.test.assertNotNull
import kotlin.test.assertNull
import kotlin.test.assertTrue

class NativeReadingSourceTest {
    private val fixture = CaptureFixture()

    @AfterEach
    fun close(): Unit = fixture.close()

    /** From the first that is tracked. */
    private fun poses(stream: StreamSpec = StreamTable.headPose): Flow<PoseSample> =
        fixture.samples(stream).filterIsInstance<PoseSample>().dropWhile { it.pose == null }

    /** Sets [fault] to [value] after five of [poses] and ends it after five untracked ones; whether each is tracked. */
    private suspend fun trackedAround(poses: Flow<PoseSample>, fault: String, value: Long): List<Boolean> {
        val isTracked = mutableListOf<Boolean>()
        poses.first { sample ->
            isTracked += sample.pose != null
            if (isTracked.size == 5) Simulation.configure(fault, value)
            if (isTracked.count { !it } == 5) Simulation.configure(fault, 0)
            false in isTracked && isTracked.last()
        }
        return isTracked
    }

    @Test
    fun aPoseIsWhereTheHeadWasAtItsStamp() = runBlocking<Unit> {
        for (sample in poses().take(20).toList()) {
            val truth = Simulation.truth(Simulation.HEAD, sample.captureNanos)
            val pose = assertNotNull(sample.pose)
            assertNear(truth.position.toRos(), pose.translation)
            // RUB to ROS, one axis at a time: the head looks along -z and its crown is along y
            val ahead = truth.rotation.rotate(Vector3(0.0, 0.0, -1.0)).toRos()
            val up = truth.rotation.rotate(Vector3(0.0, 1.0, 0.0)).toRos()
            assertNear(ahead, pose.rotation.rotate(Vector3(1.0, 0.0, 0.0)))
            assertNear(up, pose.rotation.rotate(Vector3(0.0, 0.0, 1.0)))
        }
    }

    @Test
    fun posesComeInOrderAndNotFasterThan60Hz() = runBlocking<Unit> {
        val nanos = poses().take(61).toList().map { it.captureNanos }
        assertEquals(nanos.sorted().distinct(), nanos)
        assertTrue(nanos.last() - nanos.first() > 950_000_000, "60 periods took ${nanos.last() - nanos.first()} ns")
    }

    @Test
    fun thereIsNoPoseWhileTrackingIsLost() = runBlocking<Unit> {
        val isTracked = trackedAround(poses(), "fault.head.tracking", 2)
        val lost = isTracked.indexOf(false)
        assertTrue(lost >= 5, "$isTracked")
        assertEquals(isTracked.lastIndex, isTracked.lastIndexOf(true), "$isTracked")
        assertTrue(isTracked.subList(lost, isTracked.lastIndex).none { it }, "$isTracked")
    }

    @Test
    fun theHeadSaysHowWellItIsTracked() = runBlocking<Unit> {
        Simulation.configure("fault.head.errors", 4)
        fun words(isGood: Boolean, message: String, status: String, confidence: String, errors: String) = Condition(
            isGood,
            message,
            mapOf("status" to status, "confidence" to confidence, "errors" to errors),
        )
        val dark = words(false, "the head is tracked: low_light", "valid", "1.00", "low_light")
        assertEquals(dark, poses().first().condition)
        Simulation.configure("fault.head.errors", 0)
        val fine = words(true, "the head is tracked", "valid", "1.00", "")
        poses().first { it.condition == fine }
        Simulation.configure("fault.head.tracking", 1)
        val lost = words(
            false,
            "the head is not tracked: relocalizing, not_enough_features",
            "relocalizing",
            "0.00",
            "not_enough_features",
        )
        fixture.samples(StreamTable.headPose).first { it is PoseSample && it.condition == lost }
        assertNull((fixture.samples(StreamTable.gaze).first { it is PoseSample } as PoseSample).condition)
    }

    @Test
    fun theFirstSampleInANewWorldSaysSo() = runBlocking<Unit> {
        var moving: LongRange? = null
        val sample = poses().first {
            if (moving == null) {
                val before = Native.now()
                Simulation.configure("fault.head.new_session", 1)
                moving = before..Native.now()
            }
            it.isInNewWorld
        }
        fun truth(nanos: Long) = Simulation.truth(Simulation.HEAD, nanos).position
        assertNear(truth(sample.captureNanos).toRos(), sample.pose!!.translation)
        val nearest = (assertNotNull(moving) step 1_000_000).minOf { length(truth(it)) }
        assertTrue(nearest < 0.01, "the head was never closer than $nearest m to the origin, which moved to it")
    }

    @Test
    fun aPoseOfAnInstantThatTheDeviceRefusesIsThatOfNow() = runBlocking<Unit> {
        Simulation.configure("fault.snapshot.predicted", 1)
        assertNotNull(poses().first().pose)
    }

    @Test
    fun gazeIsTracked() = runBlocking<Unit> {
        fixture.samples(StreamTable.gaze).first { it is PoseSample && it.pose != null }
    }

    @Test
    fun theControllerHasAPoseWhileItsPositionIsKnown() = runBlocking<Unit> {
        val isTracked = trackedAround(poses(StreamTable.controller), "fault.controller.tracking", 1)
        assertTrue(isTracked.indexOf(false) >= 5, "$isTracked")
        assertTrue(isTracked.count { !it } >= 5, "$isTracked")
    }

    @Test
    fun whatIsPressedOnTheControllerComesAt60Hz() = runBlocking<Unit> {
        val samples = fixture.samples(StreamTable.controllerJoy).filterIsInstance<InputSample>().take(61).toList()
        val nanos = samples.map { it.captureNanos }
        assertEquals(nanos.sorted().distinct(), nanos)
        assertTrue(nanos.last() - nanos.first() > 950_000_000, "60 periods took ${nanos.last() - nanos.first()} ns")
        assertTrue(samples.all { it.bumper != it.menu })
        assertEquals(setOf(false, true), samples.map { it.bumper }.toSet())
        for ((first, second) in samples.zipWithNext()) assertTrue(first.trigger != second.trigger)
        for (sample in samples) {
            assertEquals(if (sample.isTouched) 0.5 else 0.0, hypot(sample.touchX, sample.touchY).toDouble(), 1e-6)
            assertEquals(if (sample.isTouched) 0.25f else 0f, sample.force)
        }
    }

    @Test
    fun aControllerThatIsSwitchedOffIsTheReasonOfTheFailure() = runBlocking<Unit> {
        val failure = assertFailsWith<CaptureException.NotAvailable> {
            fixture.samples(StreamTable.controllerJoy).collect {
                Simulation.configure("fault.input.disconnected", 1)
            }
        }
        assertEquals("no controller is connected", failure.message)
    }

    @Test
    fun anUntrackedJointIsNotANumberAndKeepsThePlacesOfTheOthers() = runBlocking<Unit> {
        Simulation.configure("hidden_key_point", 4) // of the vendor's: the tip of the index finger
        val joints = joints(StreamTable.handRight).first { joints -> joints.any { !it.isUntracked() } }
        assertEquals(26, joints.size)
        assertEquals(listOf(10), joints.indices.filter { joints[it].isUntracked() })
    }

    @Test
    fun aHandThatIsNotSeenHas26UntrackedJoints() = runBlocking<Unit> {
        Simulation.configure("hands_visible", 1)
        val joints = joints(StreamTable.handRight).first()
        assertEquals(26, joints.size)
        assertTrue(joints.all { it.isUntracked() })
    }

    private fun joints(hand: StreamSpec): Flow<List<Pose>> =
        fixture.samples(hand).filterIsInstance<PosesSample>().map { it.poses }

    private fun Pose.isUntracked() =
        listOf(position.x, position.y, position.z, orientation.x, orientation.y, orientation.z, orientation.w)
            .all { it.isNaN() }

    @Test
    fun theTransformTreeAndTheHeadsOwnStreamShareTheTracker() = runBlocking<Unit> {
        val (tree, own) = listOf(StreamValues(layout = "flat"), StreamValues(backend = "sdk")).map { values ->
            fixture.samples(StreamTable.headPose, values).map { it.captureNanos }
        }
        assertNotNull(inCommon(tree, own))
    }

    private fun assertNear(expected: Vector3, found: Vector3) {
        val error = length(Vector3(expected.x - found.x, expected.y - found.y, expected.z - found.z))
        assertTrue(error < 1e-4, "expected $expected, found $found")
    }

    private fun length(it: Vector3) = hypot(hypot(it.x, it.y), it.z)

    private fun Vector3.toRos() = Vector3(-z, -x, y)
}
