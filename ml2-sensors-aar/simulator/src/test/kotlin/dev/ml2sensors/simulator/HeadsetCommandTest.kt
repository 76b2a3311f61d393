package dev.ml2sensors.simulator

import com.github.ajalt.clikt.core.CliktError
import com.github.ajalt.clikt.core.UsageError
import com.github.ajalt.clikt.core.parse
import com.github.ajalt.clikt.parsers.CommandLineParser
import dev.ml2sensors.Version
import dev.ml2sensors.simulator.replay.SyntheticRecording
import org.junit.jupiter.api.io.TempDir
import java.io.File
import kotlin.io.path.Path
import kotlin.io.path.listDirectoryEntries
import kotlin.io.path.readLines
import kotlin.test.Test
import kotlin.test.assertEquals
import kotlin.test.assertFailsWith
import kotlin.test.assertTrue

class HeadsetCommandTest {
    @TempDir
    lateinit var folder: File

    @Test
    fun wrongArgumentsAreNamedWithWhatWasExpected() {
        val recording = SyntheticRecording(folder).folder.path
        val wrong = mapOf(
            "--receiver host:0" to "expected a name, or HOST:PORT with a port of 1 to 65535, found 'host:0'",
            "--receiver host:65536" to "found 'host:65536'",
            "--receiver a:b:1" to "found 'a:b:1'",
            "--receiver :1" to "found ':1'",
            "--receiver $URI" to "HOST:PORT with a port of 1 to 65535; a URI of ml2-receiver pair is for pairing only",
            "--receiver h:1 --seed x" to "x is not a valid integer",
            "--receiver h:1 --duration 0" to "expected a positive number, found '0'",
            "--receiver h:1 --duration Infinity" to "expected a positive number, found 'Infinity'",
            "--receiver h:1 --rate-factor 2" to "--rate-factor needs --replay",
            "--receiver h:1 --replay $recording --rate-factor -1" to "expected a positive number or max, found '-1'",
            "--receiver h:1 --replay $recording/absent" to "$recording/absent",
            "--receiver h:1 --simulate seed" to "expected KEY=VALUE or KEY=VALUE@SECONDS, found 'seed'",
            "--receiver h:1 --simulate a=1 --replay $recording" to "--simulate and --replay exclude each other",
            "--receiver h:1 --subscribe /a" to "option --subscribe requires 2 values",
            "--insecure --receiver h:1 --replay $recording --subscribe /a std_msgs/String" to
                "--subscribe: expected a ROS type such as std_msgs/msg/String, of a class by its @SerialName, found",
            "--receiver h:1 --call /a std_srvs/srv/Empty" to
                "--call: expected one of std_srvs/srv/SetBool, std_srvs/srv/Trigger, found 'std_srvs/srv/Empty'",
            "--receiver h:1 --offer /a Trigger" to "--offer: expected one of std_srvs/srv/SetBool",
            "--insecure --receiver h:1 --call /a std_srvs/srv/Trigger --simulate -" to "both read standard input",
            "--receiver h:1 --unknown" to "no such option --unknown",
            "--pair http://h:1" to "expected ml2s://HOST:PORT?fp=64_HEX_DIGITS&token=32_HEX_DIGITS",
            "--insecure-eye-images --replay $recording" to "--insecure-eye-images needs --insecure",
            "--keys $folder --receiver h:1 --replay $recording" to "paired with no receiver: run ml2-receiver pair",
            "--pair $URI --insecure --replay $recording" to "--pair and --insecure exclude each other",
        )
        for ((arguments, message) in wrong) {
            val command = HeadsetCommand()
            val failure = assertFailsWith<CliktError>(arguments) { command.parse(words(arguments)) }
            val text = command.getFormattedHelp(failure).orEmpty()
            assertTrue(message in text, "$arguments: $text")
        }
    }

    @Test
    fun everyCommandLineInTheDocumentsParses() {
        val documents = listOf(Path("README.md")) + Path("../../docs").listDirectoryEntries("*.md")
        val lines = documents.flatMap { it.readLines() }.mapNotNull(EXAMPLE::find).map { it.groupValues[1] }
        assertTrue(lines.size > 8, "$lines")
        for (line in lines) {
            val parsed = CommandLineParser.parse(HeadsetCommand(), words(line))
            assertEquals(emptyList(), parsed.invocation.errors, line)
        }
    }

    @Test
    fun aRosbagIsRefusedWithAHintToMl2ReceiverPlay() {
        val bag = folder.resolve("walk").apply { mkdir() }
        val file = bag.resolve("walk_0.mcap").apply { createNewFile() }
        for (recording in listOf(bag, file)) {
            val failure = assertFailsWith<UsageError> { HeadsetCommand().parse(words("--replay $recording")) }
            assertTrue("to play it: ml2-receiver play $recording" in failure.message.orEmpty())
        }
    }

    @Test
    fun wrongArgumentsExitWith2() {
        assertEquals(2, Run("--receiver host:0").process.waitFor())
    }

    @Test
    fun damagedRecordingExitsWith2AndIsNamedBeforeAnythingStarts() {
        val files = SyntheticRecording(folder)
        files.replace("imu0/data.csv", "2e-3", "x")
        val run = Run("--receiver 127.0.0.1:1 --replay ${folder.path}")
        val expected = "Error: ${files.file("imu0/data.csv")}:2: expected a finite number, found 'x'\n"
        assertEquals(expected, run.output.readText())
        assertEquals(2, run.process.waitFor())
    }

    @Test
    fun aFailedPairingPrintsOneLineAndExitsWith1() {
        val run = Run("--keys $folder --pair $URI")
        val output = run.output.readText().lines()
        assertTrue(output[0].startsWith("Error: no pairing with the receiver at 127.0.0.1:1: "), "$output")
        assertEquals(listOf(""), output.drop(1))
        assertEquals(1, run.process.waitFor())
    }

    @Test
    fun aPairingUriIsReadFromStandardInputOrAFile() {
        val file = folder.resolve("uri").apply { writeText("$URI\r\nthis machine is 10.0.0.1, too\n") }
        for (source in listOf("-", "$file")) {
            val run = Run("--keys $folder/keys --pair $source")
            // Not closed: what shows the URI runs on until the headset has paired
            run.process.outputStream.apply { write("  $URI\n".toByteArray()) }.flush()
            assertTrue("no pairing with the receiver at 127.0.0.1:1: " in run.output.readLine(), source)
            assertEquals(1, run.process.waitFor(), source)
        }
    }

    @Test
    fun noPairingUriIsNamedWithoutRepeatingWhatMayBeAToken() {
        val almost = URI.dropLast(1)
        val wrong = folder.resolve("wrong").apply { writeText(almost) }
        val large = folder.resolve("large").apply { writeText("$URI\n".padEnd(5000)) }
        for ((source, message) in mapOf(
            almost to "expected ml2s://HOST:PORT?fp=64_HEX_DIGITS",
            almost.substringAfter("//") to "expected ml2s://HOST:PORT?fp=64_HEX_DIGITS",
            "$wrong" to "in $wrong, found another line",
            "$large" to "expected at most 4096 bytes",
            "$folder" to "expected a regular file, or - for standard input, found '$folder'",
            "/dev/zero" to "expected a regular file",
            "$folder/absent" to "expected a regular file",
        )) {
            val failure = assertFailsWith<UsageError>(source) { HeadsetCommand().parse(words("--pair $source")) }
            val text = failure.message.orEmpty()
            assertTrue(message in text && "b2b2" !in text, "$source: $text")
        }
        val other = "another line"
        for ((typed, found) in mapOf("" to "nothing", almost to other, "x".repeat(100_000) to other)) {
            val run = Run("--pair -")
            runCatching { run.process.outputStream.use { it.write(typed.toByteArray()) } }
            val text = run.output.readText()
            assertTrue("on standard input, found $found" in text && "b2b2" !in text, text)
            assertEquals(2, run.process.waitFor(), text)
        }
    }

    @Test
    fun wrongKeysAreNamedInOneLineAndExitWith2() {
        val recording = SyntheticRecording(folder).folder.path
        val file = folder.resolve("file").apply { writeText("x") }
        val damaged = folder.resolve("damaged").apply { mkdir() }
        damaged.resolve("device.p12").writeText("x")
        val replaced = folder.resolve("replaced/device.p12").apply { mkdirs() }
        val wrong = mapOf(
            "$file" to "expected a folder of keys, found the file $file: give its folder, or a new one",
            "$damaged" to "expected the key that ml2-headset has written in $damaged/device.p12, found something else",
            "${replaced.parent}" to "cannot read $replaced: expected a file that this user can read",
            "$file/keys" to "cannot write in $file/keys: give a folder that this user can write",
        )
        for ((keys, message) in wrong) {
            val failure = assertFailsWith<CliktError>(keys) {
                HeadsetCommand().parse(words("--keys $keys --receiver h:1 --replay $recording"))
            }
            val text = failure.message.orEmpty()
            assertTrue(text.startsWith("Error: $message"), text)
            assertEquals(1, text.lines().size, text)
            assertEquals(2, failure.statusCode, keys)
        }
    }

    @Test
    fun versionIsTheLibrarys() {
        val run = Run("--version")
        assertEquals("ml2-headset version ${Version.NAME}\n", run.output.readText())
        assertEquals(0, run.process.waitFor())
    }

    @Test
    fun signalsEndTheWaitForAReceiver() {
        val recording = SyntheticRecording(folder).folder
        for (signal in listOf("INT", "TERM")) {
            val run = Run("--insecure --receiver 127.0.0.1:1 --replay $recording")
            assertTrue("WARNING: --insecure" in run.output.readLine())
            assertEquals("connecting to 127.0.0.1:1", run.output.readLine())
            ProcessBuilder("kill", "-$signal", "${run.process.pid()}").start().waitFor()
            assertTrue(run.output.readText().endsWith("ended: SIG$signal\n"))
            assertEquals(0, run.process.waitFor())
        }
    }

    /** Runs the command in its own process, as users do. */
    private class Run(arguments: String) {
        private val java = File(System.getProperty("java.home"), "bin/java").path
        private val main = listOf(java, "-cp", System.getProperty("java.class.path"), "dev.ml2sensors.simulator.MainKt")

        // A background test inherits an ignored SIGINT, and so would the command
        private val withDefaultSigint = listOf("env", "--default-signal=INT")
        val process: Process =
            ProcessBuilder(withDefaultSigint + main + words(arguments)).redirectErrorStream(true).start()
        val output = process.inputStream.bufferedReader()
    }
}

private val URI = "ml2s://127.0.0.1:1?fp=${"0".repeat(64)}&token=${"b2".repeat(16)}"

/** Matches a command line in a block: the arguments, up to a comment. */
private val EXAMPLE = Regex("""^(?:\S*/ml2-headset *|(?=--[a-z]))(.*?)(?:  .*|#.*)?$""")

private fun words(arguments: String) = arguments.split(' ').filter(String::isNotEmpty)
