package dev.ml2sensors.simulator

import com.github.ajalt.clikt.core.PrintMessage
import com.github.ajalt.clikt.core.UsageError
import com.github.ajalt.clikt.parameters.groups.OptionGroup
import com.github.ajalt.clikt.parameters.options.OptionCallTransformContext
import com.github.ajalt.clikt.parameters.options.convert
import com.github.ajalt.clikt.parameters.options.default
import com.github.ajalt.clikt.parameters.options.flag
import com.github.ajalt.clikt.parameters.options.option
import dev.ml2sensors.pairing.DeviceKeys
import dev.ml2sensors.pairing.PairingUri
import dev.ml2sensors.session.Receiver
import dev.ml2sensors.simulator.keys.KeyFolder
import dev.ml2sensors.source.Headset
import dev.ml2sensors.transport.TransportSecurity
import kotlinx.coroutines.runBlocking
import java.io.IOException
import java.io.InputStream
import java.nio.file.Path
import kotlin.io.path.Path
import kotlin.io.path.fileSize
import kotlin.io.path.inputStream
import kotlin.io.path.isRegularFile

/** The receiver to connect to, and how the connection is protected. */
internal class ConnectionSettings(val receiver: Receiver, val security: TransportSecurity)

/** The options for the receiver, the keys and encryption. */
internal class ConnectionOptions : OptionGroup() {
    private val receiver by option(
        metavar = "NAME|HOST:PORT",
        help = "The receiver to connect to; default: the paired one, or with --insecure the only one on the network.",
    ).convert { failOnInvalid { Receiver.parse(it, MulticastBrowser()) } }
    val pair by option(
        metavar = "-|FILE|URI",
        help = "Pair by the URI that ml2-receiver pair shows, then exit: read from standard input or a file. " +
            "Other users of this machine can read the words of a command.",
    )
        .convert { failOnInvalid { pairingUri(it) } }
    private val keys by option(
        metavar = "FOLDER",
        help = "The folder of the keys; default: ~/.config/ml2-sensors-headset.",
    )
        .convert { Path(it) }
        .default(KeyFolder.default())
    private val insecure by option(
        help = "Do not encrypt, and trust every receiver; the receiver needs --insecure, too.",
    ).flag()
    private val insecureEyeImages by option(help = "With --insecure, send eye images, too.").flag()

    /** @return a message for the user. */
    fun pairWith(uri: PairingUri, device: Headset.Identity): String {
        if (insecure) throw UsageError("--pair and --insecure exclude each other: leave one out")
        val opened = openKeys()
        val paired = exitOnFailure(EXIT_FAILED) { runBlocking { opened.pair(uri, device) } }
        return "paired with ${paired.name} (fingerprint ${paired.fingerprint}), which serves at ${paired.address}"
    }

    /** @param warn prints a warning. */
    fun open(warn: (String) -> Unit): ConnectionSettings {
        if (insecureEyeImages && !insecure) throw UsageError("--insecure-eye-images needs --insecure")
        if (insecure) {
            warn("WARNING: --insecure: nothing is encrypted, and anyone on the network can pose as the receiver")
            return ConnectionSettings(
                receiver ?: Receiver.discover(MulticastBrowser()),
                TransportSecurity.Insecure(insecureEyeImages),
            )
        }
        val keys = openKeys()
        val paired = exitOnFailure(EXIT_USAGE) { keys.receivers }
        if (paired.isEmpty()) {
            throw UsageError("paired with no receiver: run ml2-receiver pair there, then ml2-headset --pair -")
        }
        return ConnectionSettings(receiver ?: keys.receiver(MulticastBrowser()), keys.security())
    }

    private fun openKeys(): DeviceKeys {
        useAndroidTls()
        return exitOnFailure(EXIT_USAGE) { KeyFolder(keys).open(NAME) }
    }

    private inline fun <T> exitOnFailure(exitCode: Int, action: () -> T): T = try {
        action()
    } catch (failure: IOException) {
        throw PrintMessage("Error: ${failure.message}", exitCode, printError = true)
    }

    private companion object {
        const val NAME = "ml2-headset"
        const val EXIT_FAILED = 1
    }
}

private const val STANDARD_INPUT = "-"
private const val MAX_URI_BYTES = 4096

/**
 * Reads the URI from the first line of standard input or of a file, or takes [source] itself as the URI.
 *
 * @throws IllegalArgumentException there is none; the message does not repeat what may be a token.
 */
private fun pairingUri(source: String): PairingUri {
    if ("://" in source || "token=" in source) return PairingUri.parse(source)
    val place = if (source == STANDARD_INPUT) "on standard input" else "in $source"
    val line = (if (source == STANDARD_INPUT) typedLine() else firstLineOf(Path(source))).trim()
    return try {
        PairingUri.parse(line)
    } catch (_: IllegalArgumentException) {
        val found = if (line.isEmpty()) "nothing" else "another line"
        throw IllegalArgumentException("expected ml2s://HOST:PORT?fp=...&token=... $place, found $found")
    }
}

private fun typedLine(): String {
    if (System.console() != null) System.err.println("paste the URI that `ml2-receiver pair` shows:")
    return System.`in`.firstLine()
}

private fun firstLineOf(file: Path): String {
    require(file.isRegularFile()) { "expected a regular file, or - for standard input, found '$file'" }
    require(file.fileSize() <= MAX_URI_BYTES) { "$file: expected at most $MAX_URI_BYTES bytes" }
    return try {
        file.inputStream().use { it.firstLine() }
    } catch (_: IOException) {
        throw IllegalArgumentException("cannot read $file: expected a file that this user can read")
    }
}

/** Reads no further than the line: what shows the URI may run on until the headset has paired. */
private fun InputStream.firstLine(): String {
    val characters = generateSequence { read().takeIf { it >= 0 && it != '\n'.code } }
    return characters.take(MAX_URI_BYTES).map(Int::toChar).joinToString("")
}

private inline fun <T> OptionCallTransformContext.failOnInvalid(action: () -> T): T = try {
    action()
} catch (mistake: IllegalArgumentException) {
    fail(mistake.message.orEmpty())
}
