package dev.ml2sensors.capture

import dev.ml2sensors.TEST_LIMIT
import dev.ml2sensors.clock.HostClock
import dev.ml2sensors.clock.TimeExchange
import dev.ml2sensors.message.Transform
import dev.ml2sensors.source.Answer
import dev.ml2sensors.source.CaptureMetadata
import dev.ml2sensors.source.Headset
import dev.ml2sensors.source.ImageSample
import dev.ml2sensors.source.Sample
import dev.ml2sensors.source.SensorHeadset
import dev.ml2sensors.source.SensorSource
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.source.defaultValues
import dev.ml2sensors.stream.ActiveStreams
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable
import dev.ml2sensors.wire.Status
import kotlinx.coroutines.CoroutineScope
import kotlinx.coroutines.Dispatchers
import kotlinx.coroutines.Job
import kotlinx.coroutines.asCoroutineDispatcher
import kotlinx.coroutines.cancelAndJoin
import kotlinx.coroutines.delay
import kotlinx.coroutines.flow.Flow
import kotlinx.coroutines.flow.flow
import kotlinx.coroutines.flow.flowOn
import kotlinx.coroutines.job
import kotlinx.coroutines.runBlocking
import org.junit.jupiter.api.Test
import java.nio.ByteBuffer
import java.nio.file.Path
import java.util.concurrent.Executors
import kotlin.io.path.listDirectoryEntries
import kotlin.io.path.readText
import kotlin.random.Random
import kotlin.test.assertEquals
import kotlin.test.assertTrue
import kotlin.time.Duration
import kotlin.time.Duration.Companion.milliseconds
import kotlin.time.Duration.Companion.seconds
import kotlin.time.TimeSource
import kotlin.time.measureTime

/**
 * The library that ships, on a vendor of whom one function at a time never returns: the streams of that sensor alone are
 * lost, and say so. `make harsh` tries every function, by the system properties `harsh.faults` and `harsh.seed`, and
 * holds configurations against their limit; a busy machine adds to their time.
 */
class VendorNeverReturnsTest {
    private val measuredFaults = System.getProperty("harsh.faults")?.toInt()
    private val random = Random(System.getProperty("harsh.seed", "1").toLong())
    private val took = mutableListOf<Duration>()

    @Test
    fun everyFunctionThatTheLibraryCallsIsTried() {
        val declared = Path.of("../native/sdk").listDirectoryEntries("ml_*.h").flatMap { header ->
            Regex("""\bF\((ML\w+)""").findAll(header.readText()).map { it.groupValues[1] }
        }
        assertEquals(declared.toSet(), FUNCTIONS.keys)
    }

    @Test
    fun itsStreamsAreLostAloneAndSaySoAndComeBack() = runBlocking {
        val functions = FUNCTIONS.entries.shuffled(random).take(maxOf(LEAST, (measuredFaults ?: 0) / SHARE))
        val failures = mutableListOf<String>()
        for ((function, victims) in functions) {
            val isOfTheEnd = END.any(function::endsWith)
            val isFromTheStart = !isOfTheEnd && (function in ONCE || random.nextBoolean())
            try {
                Round(function, victims).use { it.play(isFromTheStart) }
            } catch (e: Throwable) {
                failures += "$function, from the start: $isFromTheStart: $e"
            }
        }
        println("${functions.size} functions never returned; ${took.size} configurations took ${took.max()} at most")
        assertEquals(emptyList(), failures, "of those that never return")
        if (measuredFaults != null) assertTrue(took.max() <= CONFIGURED_LIMIT, "$took")
    }

    private inner class Round(private val function: String, private val victims: Set<StreamSpec>) : AutoCloseable {
        private val headset: SensorHeadset
        private val scope = CoroutineScope(Dispatchers.Default + Job())
        private val streams: ActiveStreams
        private val color = LocatedColor()

        init {
            Simulation.begin()
            Simulation.configure("still_images", 1)
            val pixels = listOf(PixelSensor.DEPTH, PixelSensor.WORLD, PixelSensor.EYE)
            val sources = pixels.map { NativePixelSource(it, NativeBackend.SDK) } +
                NativeReadingSource.all(NativeBackend.SDK) + color
            headset = SensorHeadset(Headset.Identity("harsh", "harsh"), NativeHeadsetClock, sources)
            val clock = HostClock(headset.clock)
            repeat(FIRST_EXCHANGES) { Native.now().let { clock.add(TimeExchange(it, it, it, it)) } }
            streams = ActiveStreams(headset, clock, scope)
        }

        suspend fun play(isFromTheStart: Boolean) {
            if (isFromTheStart) hold()
            configure(WANTED)
            if (!isFromTheStart) {
                WANTED.keys.forEach { awaitSamples(it) }
                hold()
            }
            if (function.endsWith("UpdateSettings")) configure(CHANGED)
            configure(WANTED - victims)
            configure(WANTED)
            val others = WANTED.keys - victims
            others.forEach { awaitSamples(it) }
            victims.forEach { await("$it says why it is lost") { it.state.run { state != RUNNING && reason != null } } }
            // Now each is in that call for sure
            configure(WANTED - victims)
            others.forEach { awaitSamples(it) }
            others.forEach { assertTrue(it.state.state == RUNNING, "$it: ${it.state.reason}") }
            Simulation.configure("held", "")
            await("the streams come back") {
                configure(WANTED)
                victims.all { it.state.state == RUNNING && produced(it) > 0 }
            }
            victims.forEach { awaitSamples(it) }
        }

        private fun hold() = Simulation.configure("held", function)

        private suspend fun configure(wanted: Map<StreamSpec, StreamValues>) {
            took += measureTime { streams.configure(wanted.mapKeys { it.key.id }, framePrefix = "", adapts = false) }
            streams.start(emptySet())
        }

        private val StreamSpec.state: Status.Stream get() = streams.reports.streamStates.getValue(id)

        private fun produced(stream: StreamSpec) = streams.reports.counts()[stream.topics.first().name]?.produced ?: 0

        private suspend fun awaitSamples(stream: StreamSpec) {
            val before = produced(stream)
            await("$stream goes on") { produced(stream) > before + 1 }
        }

        private suspend fun await(what: String, isSo: suspend () -> Boolean) {
            val start = TimeSource.Monotonic.markNow()
            while (!isSo()) {
                check(start.elapsedNow() < TEST_LIMIT) {
                    "not within $TEST_LIMIT: $what; ${WANTED.keys.associateWith { it.state.run { "$state: $reason" } }}"
                }
                delay(POLL)
            }
        }

        override fun close() {
            Simulation.configure("held", "")
            runBlocking { scope.coroutineContext.job.cancelAndJoin() }
            headset.close()
        }
    }

    /** The colour camera without its images: what its thread asks of the vendor for each of them. */
    private class LocatedColor : SensorSource {
        /** Handles of the vendor belong to a thread. */
        private val thread = Executors.newSingleThreadExecutor().asCoroutineDispatcher()
        override val backend = "camera2"
        override val streams = color

        override fun negotiate(stream: StreamSpec, requested: StreamValues) = Answer.Applied(requested)

        override fun samples(stream: StreamSpec, values: StreamValues): Flow<Sample> = flow {
            checkNotNull(NativeColorPoses.open()).use { tracker ->
                while (true) {
                    val now = Simulation.mlTime(Native.now())
                    emit(image(tracker.captureNanos(now), tracker.poseAt(now)))
                    delay(POLL)
                }
            }
        }.flowOn(thread)

        private fun image(captureNanos: Long, pose: Transform?): Sample {
            val planes = listOf(ImageSample.Plane(ImageSample.IMAGE, ByteBuffer.allocateDirect(1)))
            val metadata = CaptureMetadata()
            return ImageSample(captureNanos, frameNumber = 0, 1, 1, strideBytes = 0, pose, null, metadata, planes) {}
        }

        override fun close() = thread.close()
    }

    private companion object {
        const val RUNNING = Status.Stream.RUNNING
        const val FIRST_EXCHANGES = 16

        /** As docs/waits.md says. */
        val CONFIGURED_LIMIT = 10.seconds
        val POLL = 100.milliseconds

        /** So many functions at least, and one for so many faults. */
        const val LEAST = 2
        const val SHARE = 400

        private val color = setOf(StreamTable.color)
        private val world = setOf(StreamTable.worldLeft, StreamTable.worldRight)
        private val depth = setOf(StreamTable.depth)
        private val eyes = setOf(StreamTable.eyeNasalLeft, StreamTable.eyeNasalRight)
        private val head = setOf(StreamTable.headPose)
        private val gaze = setOf(StreamTable.gaze)
        private val hands = setOf(StreamTable.handLeft)
        private val controller = setOf(StreamTable.controller)
        private val buttons = setOf(StreamTable.controllerJoy)
        private val poses = head + gaze + hands + controller
        private val all = color + world + depth + eyes + poses + buttons
        val WANTED: Map<StreamSpec, StreamValues> = all.associateWith {
            if (it == StreamTable.depth) CaptureFixture.SHORT_RANGE else it.defaultValues()
        }

        /** One camera less of those that are opened together, and another rate of depth. */
        val CHANGED = WANTED - StreamTable.worldRight - StreamTable.eyeNasalRight +
            (StreamTable.depth to CaptureFixture.SHORT_RANGE.copy(rateHz = 60))

        /** Every function of the vendor that the library calls, and which streams need its answer. */
        val FUNCTIONS: Map<String, Set<StreamSpec>> =
            listOf("Connect", "GetLatestDepthData", "ReleaseDepthData", "Disconnect")
                .associate { "MLDepthCamera$it" to depth } +
                listOf("GetCapabilities", "ReleaseCapabilities").associate { "MLDepthCamera$it" to depth } +
                listOf("Connect", "GetLatestWorldCameraData", "ReleaseCameraData", "Disconnect", "UpdateSettings")
                    .associate { "MLWorldCamera$it" to world } +
                listOf("Connect", "GetLatestCameraData", "ReleaseCameraData", "Disconnect", "UpdateSettings")
                    .associate { "MLEyeCamera$it" to eyes } +
                listOf("TrackingCreate", "GetFramePose", "TrackingDestroy").associate { "MLCVCamera$it" to color } +
                listOf("GetStaticData", "GetStateEx", "GetMapEvents", "Destroy")
                    .associate { "MLHeadTracking$it" to head } +
                listOf("Create", "GetStaticData", "GetStateEx", "Destroy").associate { "MLEyeTracking$it" to gaze } +
                listOf("CreateEx", "GetData", "GetStaticData", "Destroy").associate { "MLHandTracking$it" to hands } +
                listOf("CreateEx", "GetStateEx", "Destroy").associate { "MLController$it" to controller } +
                listOf("Create", "GetControllerStateEx", "Destroy").associate { "MLInput$it" to buttons } +
                listOf("InitSettings", "Startup", "GetSnapshot", "ReleaseSnapshot")
                    .associate { "MLPerception$it" to all - buttons } +
                mapOf(
                    // Its one stream connects the camera anew for other values
                    "MLDepthCameraUpdateSettings" to emptySet<StreamSpec>(),
                    // Each object of the vendor that is tracked has a head tracker of its own
                    "MLHeadTrackingCreate" to poses + color,
                    "MLPerceptionGetPredictedSnapshot" to poses,
                    "MLSnapshotGetTransform" to poses,
                    "MLTimeConvertMLTimeToSystemTime" to all,
                    "MLTimeConvertSystemTimeToMLTime" to poses + buttons,
                )

        /** The calls at the end or the change of a stream. */
        val END = listOf("Disconnect", "Destroy", "UpdateSettings")

        /** The functions that are called once. */
        val ONCE = setOf(
            "MLDepthCameraGetCapabilities",
            "MLDepthCameraReleaseCapabilities",
            "MLPerceptionInitSettings",
            "MLPerceptionStartup",
        )
    }
}
