package dev.ml2sensors.simulator.replay

import dev.ml2sensors.message.Quaternion
import dev.ml2sensors.source.Answer
import dev.ml2sensors.source.Headset
import dev.ml2sensors.source.ImageSample
import dev.ml2sensors.source.PoseSample
import dev.ml2sensors.source.Sample
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.source.VectorSample
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable
import kotlinx.coroutines.CompletableDeferred
import kotlinx.coroutines.ExperimentalCoroutinesApi
import kotlinx.coroutines.Job
import kotlinx.coroutines.async
import kotlinx.coroutines.awaitAll
import kotlinx.coroutines.cancelAndJoin
import kotlinx.coroutines.flow.map
import kotlinx.coroutines.flow.take
import kotlinx.coroutines.flow.toList
import kotlinx.coroutines.launch
import kotlinx.coroutines.test.TestScope
import kotlinx.coroutines.test.currentTime
import kotlinx.coroutines.test.runTest
import org.junit.jupiter.api.io.TempDir
import java.io.File
import kotlin.test.Test
import kotlin.test.assertContentEquals
import kotlin.test.assertEquals
import kotlin.test.assertFailsWith
import kotlin.test.assertNotNull
import kotlin.test.assertNull
import kotlin.test.assertTrue

@OptIn(ExperimentalCoroutinesApi::class)
class ReplayHeadsetTest {
    @TempDir
    lateinit var folder: File

    private val files by lazy { SyntheticRecording(folder) }
    private val values = StreamValues()

    @Test
    fun captureTimesAreRecordedTimesPlusOneConstantForAllStreams() = runTest {
        val headset = headset(1.0)
        val streams = listOf(StreamTable.worldRight, StreamTable.gyroLeft, StreamTable.accelLeft, StreamTable.headPose)
        val captured = streams.map { async { headset.captures(it) } }.awaitAll()
        val recording = files.open()
        val constant = CLOCK_START_NANOS + LEAD_NANOS - recording.groundTruth!!.stamps.first()
        assertEquals(recording.right!!.images.map { it.stampNanos + constant }, captured[0])
        assertEquals(recording.imu!!.stamps.map { it + constant }, captured[1])
        assertEquals(captured[1], captured[2])
        assertEquals(recording.groundTruth.stamps.map { it + constant }, captured[3])
    }

    @Test
    fun samplesAreDeliveredWhenTheyAreDueAndKeepTheirCaptureTimes() = runTest {
        val recording = files.open()
        val cases = listOf(
            Triple(StreamTable.gyroLeft, recording.imu!!.stamps.toList(), 1.0),
            Triple(StreamTable.worldLeft, recording.left!!.images.map { it.stampNanos }, 1.0),
            Triple(StreamTable.headPose, recording.groundTruth!!.stamps.toList(), 4.0),
        )
        for ((stream, stamps, rateFactor) in cases) {
            val start = currentTime
            val samples = headset(rateFactor).samples(stream, values).map { it.captureNanos to currentTime }.toList()
            assertEquals(stamps.map { start + dueMillis(it, rateFactor) }, samples.map { it.second }, "$stream")
            assertEquals(stamps.map { it - stamps[0] }, samples.map { it.first - samples[0].first }, "$stream")
        }
    }

    @Test
    fun infiniteRateDeliversWithoutWaiting() = runTest {
        val times = headset(Double.POSITIVE_INFINITY).samples(StreamTable.gyroLeft, values).map { currentTime }.toList()
        assertEquals(List(10) { LEAD_NANOS / 1_000_000 }, times)
    }

    @Test
    fun imuValuesAreThoseOfTheFile() = runTest {
        val imu = files.open().imu!!
        val headset = headset(1.0)
        val gyro = headset.samples(StreamTable.gyroLeft, values).toList().map { it as VectorSample }
        val accel = headset.samples(StreamTable.accelLeft, values).toList().map { it as VectorSample }
        assertEquals(imu.gyro.map { it.toList() }, gyro.map { listOf(it.x, it.y, it.z) })
        assertEquals(imu.accel.map { it.toList() }, accel.map { listOf(it.x, it.y, it.z) })
    }

    @Test
    fun headPoseIsTheRowOfTheFile() = runTest {
        val poses = headset(1.0).samples(StreamTable.headPose, values).toList().map { (it as PoseSample).pose }
        assertEquals(Quaternion(0.6, 0.0, 0.0, 0.8), poses[1]?.rotation)
        assertEquals(files.open().groundTruth!!.poses, poses)
    }

    @Test
    fun imagesCarryPixelsCalibrationAndNumber() = runTest {
        val camera = files.open().left!!
        var number = 0
        headset(1.0).samples(StreamTable.worldLeft, values).collect { sample ->
            val image = sample as ImageSample
            assertContentEquals(SyntheticRecording.pixels(number), image.copy())
            assertEquals(listOf(5, 3, 5), listOf(image.width, image.height, image.strideBytes))
            assertEquals(camera.intrinsics, image.intrinsics)
            assertEquals(number++.toLong(), image.frameNumber)
        }
        assertEquals(3, number)
    }

    @Test
    fun opticalFrameIsTheInterpolatedBodyTimesTheExtrinsics() = runTest {
        val recording = files.open()
        val truth = recording.groundTruth!!
        val poses = headset(1.0).samples(StreamTable.worldLeft, values).map { (it as ImageSample).pose }.toList()
        recording.left!!.images.forEachIndexed { index, image ->
            val pose = assertNotNull(poses[index])
            val fraction = (image.stampNanos - truth.stamps[index]) / 50e6
            val start = RotationMatrix.of(truth.poses[index].rotation)
            val turn = start.transposed() * RotationMatrix.of(truth.poses[index + 1].rotation)
            val body = start * turn.scaled(fraction)
            val lever = body * doubleArrayOf(0.25, -0.5, 2.0)
            assertEquals(index + fraction + lever[0], pose.translation.x, 1e-9)
            assertEquals(2 + lever[1], pose.translation.y, 1e-9)
            assertEquals(3 + lever[2], pose.translation.z, 1e-9)
            val mounted = RotationMatrix(arrayOf(row(0, -1, 0), row(1, 0, 0), row(0, 0, 1)))
            val optical = RotationMatrix.of(pose.rotation)
            for (r in 0..2) for (c in 0..2) assertEquals((body * mounted)[r, c], optical[r, c], 1e-9)
        }
    }

    @Test
    fun imagesOutsideOfTheGroundTruthHaveNoPose() = runTest {
        files.replace("state_groundtruth_estimate0/data.csv", "1403715273262142969,", "1403715273262142977,")
        val poses = headset(1.0).samples(StreamTable.worldLeft, values).map { (it as ImageSample).pose }.toList()
        assertNull(poses[0])
        assertNotNull(poses[1])
    }

    @Test
    fun aFlowCollectedAgainResumesWhereItStopped() = runTest {
        val flow = headset(1.0).samples(StreamTable.gyroLeft, values)
        val first = flow.take(4).toList()
        assertEquals(files.open().imu!!.gyro.map { it[0] }, (first + flow.toList()).map { (it as VectorSample).x })
        assertEquals(emptyList<Sample>(), flow.toList())
    }

    @Test
    fun everyCollectorGetsTheWholeStream() = runTest {
        val headset = headset(1.0)
        val streams = listOf(StreamTable.gyroLeft, StreamTable.gyroLeft, StreamTable.worldLeft, StreamTable.worldLeft)
        val sizes = streams.map { async { headset.captures(it).size } }.awaitAll()
        assertEquals(listOf(10, 10, 3, 3), sizes)
    }

    @Test
    fun imagesWaitForABufferInsteadOfBeingDropped() = runTest {
        val kept = mutableListOf<ImageSample>()
        val collection = leaseAllBuffers(twelveImages(), kept)
        kept.toList().forEach(ImageSample::release)
        collection.join()
        assertEquals((0L until 12).toList(), kept.map { it.frameNumber })
    }

    @Test
    fun cancellingTheWaitForABufferLosesNoImage() = runTest {
        val headset = twelveImages()
        val kept = mutableListOf<ImageSample>()
        leaseAllBuffers(headset, kept).cancelAndJoin()
        kept.forEach(ImageSample::release)
        val rest = headset.samples(StreamTable.worldLeft, values).map { (it as ImageSample).frameNumber }.toList()
        assertEquals((8L until 12).toList(), rest)
    }

    @Test
    fun imageThatCannotBeDecodedFailsTheFlowNamingTheFile() = runTest {
        val image = damagedSecondImage()
        val seen = mutableListOf<Sample>()
        val failure = assertFailsWith<RecordingException> {
            headset(1.0).samples(StreamTable.worldLeft, values).collect(seen::add)
        }
        assertEquals(image, failure.file)
        assertEquals(1, seen.size)
    }

    @Test
    fun imageThatCannotBeDecodedReturnsItsBuffer() = runTest {
        damagedSecondImage()
        val flow = headset(1.0).samples(StreamTable.worldLeft, values)
        repeat(20) { assertFailsWith<RecordingException> { flow.toList() } }
    }

    @Test
    fun closingEndsTheFlows() = runTest {
        val headset = headset(1.0)
        val seen = mutableListOf<Sample>()
        headset.samples(StreamTable.gyroLeft, values).collect {
            seen += it
            if (seen.size == 3) headset.close()
        }
        assertEquals(3, seen.size)
        assertTrue(headset.samples(StreamTable.worldLeft, values).toList().isEmpty())
    }

    @Test
    fun cameraRequestIsAdjustedToTheRecordedMode() = runTest {
        val asked = StreamValues(stream = 1, width = 1016, height = 1016, rateHz = 30, format = "Grayscale")
        val recorded = asked.copy(width = 5, height = 3, rateHz = 20)
        val headset = headset(1.0)
        assertEquals(
            Answer.Adjusted(recorded, "the recording's own"),
            headset.negotiate(StreamTable.worldLeft, asked),
        )
        assertEquals(Answer.Applied(recorded), headset.negotiate(StreamTable.worldRight, recorded))
        val imu = StreamValues(accelerationVariance = 0.1)
        assertEquals(Answer.Applied(imu), headset.negotiate(StreamTable.accelLeft, imu))
    }

    @Test
    fun sensorsThatWereNotRecordedAreRefused() = runTest {
        files.file("cam1").deleteRecursively()
        val headset = headset(1.0)
        val recorded = setOf(
            StreamTable.worldLeft,
            StreamTable.accelLeft,
            StreamTable.gyroLeft,
            StreamTable.headPose,
        )
        for (stream in StreamTable.all - recorded) {
            assertEquals(Answer.Refused("not in this recording"), headset.negotiate(stream, values), "$stream")
            assertFailsWith<IllegalArgumentException> { headset.samples(stream, values) }
        }
    }

    @Test
    fun identityNamesTheRecording() = runTest {
        val headset = headset(1.0)
        assertEquals("replay-${folder.name}", headset.identity.deviceId)
        assertEquals(Headset.Timeline.RECORDED, headset.timeline)
    }

    private fun TestScope.headset(rateFactor: Double) =
        ReplayHeadset(files.open(), { CLOCK_START_NANOS + currentTime * 1_000_000 }, rateFactor)

    private fun damagedSecondImage(): File =
        files.file("cam0/data/${SyntheticRecording.stamp(1)}.png").also { it.writeBytes(it.readBytes().copyOf(50)) }

    private fun TestScope.twelveImages(): Headset {
        val more = (3 until 12).joinToString("") {
            "${SyntheticRecording.stamp(it)},${SyntheticRecording.stamp(0)}.png\r\n"
        }
        files.file("cam0/data.csv").appendText(more)
        return headset(Double.POSITIVE_INFINITY)
    }

    /** Collects and retains images into [kept]; returns when all eight buffers of the headset are in use. */
    private suspend fun TestScope.leaseAllBuffers(headset: Headset, kept: MutableList<ImageSample>): Job {
        val eighth = CompletableDeferred<Unit>()
        val collection = launch {
            headset.samples(StreamTable.worldLeft, values).collect { sample ->
                kept += (sample as ImageSample).also { it.retain() }
                if (kept.size == 8) eighth.complete(Unit)
            }
        }
        eighth.await()
        return collection
    }

    private suspend fun Headset.captures(stream: StreamSpec) = samples(stream, values).map { it.captureNanos }.toList()

    /** Returns the due time in milliseconds of virtual time, rounded up as delays are. */
    private fun dueMillis(recordedNanos: Long, rateFactor: Double): Long {
        val sinceFirst = (recordedNanos - files.open().groundTruth!!.stamps.first()) / rateFactor
        return (LEAD_NANOS + sinceFirst.toLong() + 999_999) / 1_000_000
    }

    private fun row(vararg entries: Int) = entries.map(Int::toDouble).toDoubleArray()

    private companion object {
        const val CLOCK_START_NANOS = 5_000_000_000_123L
        const val LEAD_NANOS = 200_000_000L
    }
}
