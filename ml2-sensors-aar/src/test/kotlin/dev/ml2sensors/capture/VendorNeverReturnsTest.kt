package dev.ml2sensors.capture

import dev.ml2sensors.TEST_LIMIT
import dev.ml2sensors.clock.HostClock
import dev.ml2sensors.clock.TimeExchange
import dev.ml2sensors.source.Headset
import dev.ml2sensors.source.SensorHeadset
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.source.defaultValues
import dev.ml2sensors.stream.ActiveStreams
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable
import dev.ml2sensors.wire.Status
import kotlinx.coroutines.CoroutineScope
import kotlinx.coroutines.Dispatchers
import kotlinx.coroutines.Job
import kotlinx.coroutines.cancelAndJoin
import kotlinx.coroutines.delay
import kotlinx.coroutines.job
import kotlinx.coroutines.runBlocking
import org.junit.jupiter.api.Test
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
    fun itsStreamsAreLostAloneAndSaySoAndComeBack() = runBlocking {
        val functions = FUNCTIONS.entries.shuffled(random).take(maxOf(LEAST, (measuredFaults ?: 0) / SHARE))
        val failures = mutableListOf<String>()
        for ((function, victims) in functions) {
            val isOfTheEnd = function.endsWith("Disconnect") || function.endsWith("Destroy")
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

        init {
            Simulation.begin()
            Simulation.configure("still_images", 1)
            val pixels = listOf(PixelSensor.DEPTH, PixelSensor.WORLD, PixelSensor.EYE)
            val sources = pixels.map { NativePixelSource(it, NativeBackend.SDK) } +
                ReadingSensor.entries.map { NativeReadingSource(it, NativeBackend.SDK) }
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
            configure(WANTED - victims)
            configure(WANTED)
            val others = WANTED.keys - victims
            others.forEach { awaitSamples(it) }
            victims.forEach { await("$it says why it is lost") { it.state.run { state != RUNNING && reason != null } } }
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

        private val StreamSpec.state: Status.Stream get() = streams.streamStates.getValue(id)

        private fun produced(stream: StreamSpec) = streams.counts()[stream.topics.first().name]?.produced ?: 0

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

    private companion object {
        const val RUNNING = Status.Stream.RUNNING
        const val FIRST_EXCHANGES = 16

        /** As docs/waits.md says. */
        val CONFIGURED_LIMIT = 10.seconds
        val POLL = 100.milliseconds

        /** So many functions at least, and one for so many faults. */
        const val LEAST = 2
        const val SHARE = 400

        private val world = setOf(StreamTable.worldLeft)
        private val depth = setOf(StreamTable.depth)
        private val eyes = setOf(StreamTable.eyeNasalLeft)
        private val head = setOf(StreamTable.headPose)
        private val gaze = setOf(StreamTable.gaze)
        private val hands = setOf(StreamTable.handLeft)
        private val controller = setOf(StreamTable.controller)
        private val buttons = setOf(StreamTable.controllerJoy)
        private val poses = head + gaze + hands + controller
        private val all = world + depth + eyes + poses + buttons
        val WANTED: Map<StreamSpec, StreamValues> = all.associateWith {
            if (it == StreamTable.depth) CaptureFixture.SHORT_RANGE else it.defaultValues()
        }

        /** Every function of the vendor that the library calls for these streams, and which of them need its answer. */
        val FUNCTIONS: Map<String, Set<StreamSpec>> =
            listOf("Connect", "GetLatestDepthData", "ReleaseDepthData", "Disconnect", "GetCapabilities")
                .associate { "MLDepthCamera$it" to depth } +
                listOf("Connect", "GetLatestWorldCameraData", "ReleaseCameraData", "Disconnect")
                    .associate { "MLWorldCamera$it" to world } +
                listOf("Connect", "GetLatestCameraData", "ReleaseCameraData", "Disconnect")
                    .associate { "MLEyeCamera$it" to eyes } +
                listOf("GetStaticData", "GetStateEx", "GetMapEvents", "Destroy")
                    .associate { "MLHeadTracking$it" to head } +
                listOf("Create", "GetStaticData", "GetStateEx", "Destroy").associate { "MLEyeTracking$it" to gaze } +
                listOf("CreateEx", "GetData", "GetStaticData", "Destroy").associate { "MLHandTracking$it" to hands } +
                listOf("CreateEx", "GetStateEx", "Destroy").associate { "MLController$it" to controller } +
                listOf("Create", "GetControllerStateEx", "Destroy").associate { "MLInput$it" to buttons } +
                listOf("PerceptionStartup", "PerceptionGetSnapshot", "PerceptionReleaseSnapshot")
                    .associate { "ML$it" to all - buttons } +
                mapOf(
                    // Each object of the vendor that is tracked has a head tracker of its own
                    "MLHeadTrackingCreate" to poses,
                    "MLPerceptionGetPredictedSnapshot" to poses,
                    "MLTimeConvertMLTimeToSystemTime" to all,
                )

        /** What is called once. */
        val ONCE = setOf("MLDepthCameraGetCapabilities", "MLPerceptionStartup")
    }
}
