package dev.ml2sensors.simulator

import com.github.ajalt.clikt.core.Context
import com.github.ajalt.clikt.core.CoreCliktCommand
import com.github.ajalt.clikt.core.PrintMessage
import com.github.ajalt.clikt.core.ProgramResult
import com.github.ajalt.clikt.core.UsageError
import com.github.ajalt.clikt.core.context
import com.github.ajalt.clikt.parameters.groups.provideDelegate
import com.github.ajalt.clikt.parameters.options.convert
import com.github.ajalt.clikt.parameters.options.default
import com.github.ajalt.clikt.parameters.options.multiple
import com.github.ajalt.clikt.parameters.options.option
import com.github.ajalt.clikt.parameters.options.transformValues
import com.github.ajalt.clikt.parameters.options.versionOption
import com.github.ajalt.clikt.parameters.types.file
import com.github.ajalt.clikt.parameters.types.long
import dev.ml2sensors.Version
import dev.ml2sensors.pairing.PairingUri
import dev.ml2sensors.simulator.replay.EurocRecording
import dev.ml2sensors.simulator.replay.RecordingException
import dev.ml2sensors.simulator.replay.ReplayHeadset
import dev.ml2sensors.simulator.simulated.NativeBundle
import dev.ml2sensors.source.DeviceClock
import dev.ml2sensors.source.Headset
import kotlinx.coroutines.CompletableDeferred
import kotlinx.coroutines.runBlocking
import sun.misc.Signal
import java.io.File
import kotlin.random.Random
import kotlin.time.Duration.Companion.seconds

internal const val EXIT_USAGE = 2

/** The command `ml2-headset`: parses its options, opens a headset and streams it. */
internal class HeadsetCommand : CoreCliktCommand("ml2-headset") {
    private val connection by ConnectionOptions()
    private val replay by option(metavar = "DIR", help = "Replay this EuRoC/ASL data set instead of simulating.")
        .file(mustExist = true)
    private val simulation by SimulationOptions()
    private val seed by option(metavar = "N", help = "Seed of the scene, the trajectory and all noise; default 1.")
        .long().default(1)
    private val duration by option(metavar = "S", help = "Stop S seconds after the first sample.")
        .convert { (positive(it) ?: fail("expected a positive number, found '$it'")).seconds }
    private val rateFactor by option(
        metavar = "X|max",
        help = "Replay X times as fast as recorded; max: as fast as the receiver takes it.",
    )
        .convert { rateFactor(it) ?: fail("expected a positive number or max, found '$it'") }
    private val subscribed by option(
        "--subscribe",
        metavar = "TOPIC TYPE",
        help = "Print the messages of a ROS topic, as far as the receiver's app.subscribe allows it; repeatable.",
    )
        .transformValues(2) { (topic, type) -> PrintedTopic(topic, type) }
        .multiple()
    private val called by option(
        "--call",
        metavar = "SERVICE TYPE",
        help = "Call a ROS service, as far as the receiver's app.call allows it, by lines SERVICE SECONDS JSON of " +
            "standard input; repeatable.",
    )
        .transformValues(2) { (service, type) -> CalledService(service, type) }
        .multiple()
    private val published by option(
        "--publish",
        metavar = "TOPIC BYTES HZ WILL_MS",
        help =
        "Publish std_msgs/msg/UInt8MultiArray, as far as the receiver allows it, at 0 Hz once and latched, with an " +
            "empty will after so many ms unless that is 0; repeatable.",
    )
        .transformValues(4) { (topic, bytes, rate, will) ->
            val rateHz = rate.toDoubleOrNull()?.takeIf { it >= 0 && it.isFinite() }
            val count = bytes.toIntOrNull()?.takeIf { it >= 0 }
            val silent = will.toLongOrNull()?.takeIf { it >= 0 }
            if (rateHz == null || count == null || silent == null) fail("expected numbers, found '$bytes $rate $will'")
            PublishedTopic(topic, count, rateHz, silent)
        }
        .multiple()
    private val transforms by option(
        "--transform",
        metavar = "FRAME REFERENCE",
        help = "Print the pose of a frame in another, as far as the receiver's app.subscribe has /tf; repeatable.",
    )
        .transformValues(2) { (frame, reference) -> PrintedTransform(frame, reference) }
        .multiple()
    private val offered by option(
        "--offer",
        metavar = "SERVICE TYPE",
        help = "Offer a service to ROS, as far as the receiver's app.offer allows it, and print requests; repeatable.",
    )
        .transformValues(2) { (service, type) -> OfferedService(service, type) }
        .multiple()

    init {
        versionOption(Version.NAME)
        // clikt-core prints errors to standard output, too
        context {
            echoMessage = { _, message, newline, isError ->
                val stream = if (isError) System.err else System.out
                if (newline) stream.println(message) else stream.print(message)
            }
        }
    }

    override fun help(context: Context): String = "Streams a simulated or recorded headset to a receiver."

    override fun run() {
        val uri = connection.pair
        val isOk = headset().use { if (uri == null) stream(it) else pair(it, uri) }
        if (!isOk) throw ProgramResult(1)
    }

    private fun stream(headset: Headset): Boolean {
        val connection = connection.open { echo(it, err = true) }
        return runBlocking {
            val parts = AppParts(subscribed + transforms, called, offered, published)
            stream(headset, connection, duration, stopSignal(), parts, ::echo) {
                if (headset is SimulatedHeadset) simulation.setLater(headset, ::echo)
            }
        }
    }

    private fun pair(headset: Headset, uri: PairingUri): Boolean {
        echo(connection.pairWith(uri, headset.identity))
        return true
    }

    private fun headset(): Headset {
        val folder = replay
        if (rateFactor != null && folder == null) throw UsageError("--rate-factor needs --replay")
        if (simulation.isGiven && folder != null) throw UsageError("--simulate and --replay exclude each other")
        if (called.isNotEmpty() && simulation.isReading) {
            throw UsageError("--call and --simulate - exclude each other: both read standard input")
        }
        if (folder == null) return simulation.open(seed, System.getProperty("ml2s.frame_cache", ""))
        NativeBundle.load() // Images of a replay may be compressed
        return ReplayHeadset(recording(folder), shiftedClock(), rateFactor ?: 1.0)
    }

    private fun shiftedClock(): DeviceClock {
        val offsetNanos = Random(seed).nextLong(MAX_CLOCK_OFFSET_NANOS)
        return DeviceClock { System.nanoTime() + offsetNanos }
    }

    private fun recording(folder: File): EurocRecording {
        val isBag = (listOf(folder) + folder.listFiles().orEmpty()).any { it.extension == "mcap" }
        if (isBag) {
            throw UsageError(
                "--replay expects a EuRoC/ASL folder, found a rosbag2 recording; to play it: ml2-receiver play $folder",
            )
        }
        try {
            return EurocRecording.open(folder).also { recording -> recording.notes.forEach { echo(it, err = true) } }
        } catch (failure: RecordingException) {
            throw PrintMessage("Error: ${failure.message}", EXIT_USAGE, printError = true)
        }
    }

    private companion object {
        /** A large offset from every other clock, so that a time that was not converted is noticed. */
        const val MAX_CLOCK_OFFSET_NANOS = 1L shl 50
    }
}

private fun positive(text: String): Double? = text.toDoubleOrNull()?.takeIf { it > 0 && it.isFinite() }

private fun rateFactor(text: String): Double? = if (text == "max") Double.POSITIVE_INFINITY else positive(text)

/** Completes with the name of the first SIGINT or SIGTERM. Neither signal ends the process from then on. */
private fun stopSignal(): CompletableDeferred<String> {
    val stop = CompletableDeferred<String>()
    for (name in listOf("INT", "TERM")) Signal.handle(Signal(name)) { stop.complete("SIG$name") }
    return stop
}
