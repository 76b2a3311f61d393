package dev.ml2sensors.stream

import dev.ml2sensors.conformance.FluidPressure
import dev.ml2sensors.conformance.Illuminance
import dev.ml2sensors.message.BatteryState
import dev.ml2sensors.message.Detection3DArray
import dev.ml2sensors.message.Imu
import dev.ml2sensors.message.Joy
import dev.ml2sensors.message.MagneticField
import dev.ml2sensors.message.Point
import dev.ml2sensors.message.Pose
import dev.ml2sensors.message.PoseArray
import dev.ml2sensors.message.PoseStamped
import dev.ml2sensors.message.Quaternion
import dev.ml2sensors.message.Transform
import dev.ml2sensors.message.Vector3
import dev.ml2sensors.message.toPose
import dev.ml2sensors.session.HostFrame
import dev.ml2sensors.source.BatterySample
import dev.ml2sensors.source.ChargeStatus
import dev.ml2sensors.source.DropReason
import dev.ml2sensors.source.InputSample
import dev.ml2sensors.source.LostSamples
import dev.ml2sensors.source.Marker
import dev.ml2sensors.source.MarkersSample
import dev.ml2sensors.source.PoseSample
import dev.ml2sensors.source.PosesSample
import dev.ml2sensors.source.Sample
import dev.ml2sensors.source.ScalarSample
import dev.ml2sensors.source.VectorSample
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable
import kotlinx.coroutines.runBlocking
import org.junit.jupiter.api.AfterEach
import org.junit.jupiter.api.Test
import kotlin.test.assertContentEquals
import kotlin.test.assertEquals
import kotlin.test.assertTrue

class MeasurementTest {
    private val fixture = StreamFixture()
    private val headset = fixture.headset
    private val pose = Transform(Vector3(1.0, -2.0, 3.0), Quaternion(0.5, -0.5, 0.5, 0.5))

    @AfterEach
    fun close() = fixture.close()

    @Test
    fun halvesOfAnImuSayWhatTheyDidNotMeasure() {
        val gyroscope = carry(StreamTable.gyroLeft, "{}", VectorSample(fixture.now, 1.0, 2.0, 3.0)).message<Imu>()
        assertEquals("imu_left_frame", gyroscope.header.frameId)
        assertEquals(Vector3(1.0, 2.0, 3.0), gyroscope.angularVelocity)
        assertContentEquals(DoubleArray(9), gyroscope.angularVelocityCovariance)
        assertEquals(-1.0, gyroscope.linearAccelerationCovariance[0])
        assertEquals(-1.0, gyroscope.orientationCovariance[0])
    }

    @Test
    fun configuredVariancesAreTheDiagonal() {
        val values = """{"linear_acceleration_variance": 0.25}"""
        val accelerometer =
            carry(StreamTable.accelRight, values, VectorSample(fixture.now, 0.0, 9.81, 0.0)).message<Imu>()
        assertEquals(Vector3(0.0, 9.81, 0.0), accelerometer.linearAcceleration)
        val diagonal = doubleArrayOf(0.25, 0.0, 0.0, 0.0, 0.25, 0.0, 0.0, 0.0, 0.25)
        assertContentEquals(diagonal, accelerometer.linearAccelerationCovariance)
        assertEquals(-1.0, accelerometer.angularVelocityCovariance[0])
    }

    @Test
    fun unitedUnitsCarryBothHalves() = runBlocking<Unit> {
        val session = fixture.start("""{"imu_left": {"angular_velocity_variance": 0.5}}""")
        val base = fixture.now
        for (offset in listOf(0L, 20)) {
            headset.deliver(StreamTable.accelLeft, VectorSample(base + offset, 0.0, offset.toDouble(), 0.0))
        }
        for (offset in listOf(5L, 10)) headset.deliver(StreamTable.gyroLeft, VectorSample(base + offset, 1.0, 2.0, 3.0))
        val messages = session.awaitData("imu_left/imu", 2).map { it.message<Imu>() }
        assertEquals(listOf(5.0, 10.0), messages.map { it.linearAcceleration.y })
        assertEquals(List(2) { Vector3(1.0, 2.0, 3.0) }, messages.map { it.angularVelocity })
        assertEquals(
            0.5 to 0.0,
            messages[0].angularVelocityCovariance[0] to messages[0].linearAccelerationCovariance[0],
        )
        assertEquals(5, session.data("imu_left/imu").let { it[1].captureNanos - it[0].captureNanos })
    }

    @Test
    fun lightIsInLux() {
        val light = carry(StreamTable.lightSensor, "{}", ScalarSample(fixture.now, 321.5)).message<Illuminance>()
        assertEquals(321.5 to 0.0, light.illuminance to light.variance)
    }

    @Test
    fun pressureIsInPascal() {
        val sample = ScalarSample(fixture.now, 101_325.0)
        val pressure = carry(StreamTable.pressureComputePack, "{}", sample).message<FluidPressure>()
        assertEquals(101_325.0 to 0.0, pressure.fluidPressure to pressure.variance)
    }

    @Test
    fun magneticFieldsAreInTesla() {
        val sample = VectorSample(fixture.now, 1e-6, 2e-6, 3e-6)
        val field = carry(StreamTable.magnetometerLeft, "{}", sample).message<MagneticField>()
        assertEquals(Vector3(1e-6, 2e-6, 3e-6), field.magneticField)
        assertContentEquals(DoubleArray(9), field.magneticFieldCovariance)
    }

    @Test
    fun posesAreSentWhileTheyAreTracked() = runBlocking<Unit> {
        val session = fixture.start("""{"head_pose": {}}""")
        for (tracked in listOf(null, pose, null)) {
            // To the watch of tracking events, too
            headset.deliver(StreamTable.headPose, PoseSample(fixture.now, tracked), times = 2)
        }
        val sent = session.awaitData("head_pose")[0].message<PoseStamped>()
        assertEquals("magicleap_world", sent.header.frameId)
        assertEquals(Pose(Point(1.0, -2.0, 3.0), pose.rotation), sent.pose)
        assertEquals(1, fixture.finish(session).getValue("head_pose").produced)
    }

    @Test
    fun handsAreTheirJoints() {
        val joints = List(26) { Pose(Point(it.toDouble(), 0.0, 0.0), Quaternion.IDENTITY) }
        val hand = carry(StreamTable.handRight, "{}", PosesSample(fixture.now, joints)).message<PoseArray>()
        assertEquals(joints, hand.poses)
    }

    @Test
    fun axesAndButtonsOfTheControllerHaveTheirPlaces() {
        val sample = InputSample(
            fixture.now,
            trigger = 0.75f,
            bumper = true,
            menu = false,
            isTouched = true,
            touchX = -0.5f,
            touchY = 0.25f,
            force = 0.125f,
        )
        val joy = carry(StreamTable.controllerJoy, "{}", sample).message<Joy>()
        assertEquals("controller_frame", joy.header.frameId)
        assertEquals(listOf(0.75f, -0.5f, 0.25f, 0.125f), joy.axes)
        assertEquals(listOf(1, 0, 1), joy.buttons)
    }

    @Test
    fun markersAreDetectionsThatTheirFrameIdentifies() {
        val markers = listOf(Marker("tag36h11:7", "7", pose, sizeM = 0.16, reprojectionErrorM = 0.5))
        val message = carry(StreamTable.markers, "{}", MarkersSample(fixture.now, markers)).message<Detection3DArray>()
        assertEquals("magicleap_world", message.header.frameId)
        val detection = message.detections.single()
        assertEquals(message.header, detection.header)
        assertEquals("tag36h11:7", detection.id)
        assertEquals(Vector3(0.16, 0.16, 0.0), detection.bbox.size)
        assertEquals(pose.toPose(), detection.bbox.center)
        val result = detection.results.single()
        assertEquals("7" to 1.0, result.hypothesis.classId to result.hypothesis.score)
        assertEquals(pose.toPose(), result.pose.pose)
        val diagonal = DoubleArray(36) { if (it in listOf(0, 7, 14)) 0.25 else 0.0 }
        assertContentEquals(diagonal, result.pose.covariance)
    }

    @Test
    fun batteriesSayUnknownWhereTheDeviceDoes() {
        val sample = BatterySample(fixture.now, 3.7f, -1.25f, 0.5f, ChargeStatus.FULL, temperature = 31.5f)
        val battery = carry(StreamTable.battery, "{}", sample).message<BatteryState>()
        assertEquals(listOf(3.7f, -1.25f, 0.5f), listOf(battery.voltage, battery.current, battery.percentage))
        assertTrue(listOf(battery.charge, battery.capacity, battery.designCapacity).all(Float::isNaN))
        assertEquals(31.5f, battery.temperature)
        assertEquals(4.toUByte() to true, battery.powerSupplyStatus to battery.present)
    }

    @Test
    fun whatASourceLostIsCounted() = runBlocking<Unit> {
        val session = fixture.start("""{"battery": {}}""")
        headset.deliver(StreamTable.battery, LostSamples(fixture.now, 4, DropReason.SOURCE_LATE))
        assertEquals(Counters(4, 0, mapOf("source_late" to 4)), fixture.finish(session).getValue("battery"))
    }

    /** The message that comes of [sample]. */
    private fun carry(stream: StreamSpec, values: String, sample: Sample): HostFrame = runBlocking {
        val session = fixture.start("""{"${stream.id}": $values}""")
        headset.deliver(stream, sample)
        val frame = session.awaitData(stream.topics.single().name)[0]
        assertEquals(0, frame.sequence)
        frame
    }
}
