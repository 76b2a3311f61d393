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
import kotlin.io.path.Path

/** Which receiver, and how the way there is protected. */
internal class Link(val receiver: Receiver, val security: TransportSecurity)

/** The options that say so. */
internal class LinkOptions : OptionGroup() {
    private val receiver by option(
        metavar = "NAME|HOST:PORT",
        help = "Which receiver; default: the one that is paired, with --insecure the one there is.",
    ).convert { parsing { Receiver.parse(it, MulticastBrowser()) } }
    val pair by option(metavar = "URI", help = "Pair with the receiver whose ml2-receiver pair shows this, and end.")
        .convert { parsing { PairingUri.parse(it) } }
    private val keys by option(metavar = "FOLDER", help = "The keys; default: ~/.config/ml2-sensors-headset.")
        .convert { Path(it) }
        .default(KeyFolder.default())
    private val insecure by option(help = "Encrypt nothing, trust everybody; the receiver must be told, too.").flag()
    private val insecureEyeImages by option(help = "With --insecure, send images of the eyes all the same.").flag()

    /** @return what is to be said. */
    fun pairWith(uri: PairingUri, device: Headset.Identity): String {
        if (insecure) throw UsageError("--pair and --insecure exclude each other")
        val opened = openKeys()
        val paired = failing(EXIT_FAILED) { runBlocking { opened.pair(uri, device) } }
        return "paired with ${paired.name} (fingerprint ${paired.fingerprint}), which serves at ${paired.address}"
    }

    /** @param warn is told what the user must not overlook. */
    fun open(warn: (String) -> Unit): Link {
        if (insecureEyeImages && !insecure) throw UsageError("--insecure-eye-images needs --insecure")
        if (insecure) {
            warn("WARNING: --insecure: nothing is encrypted, and any machine can impersonate the receiver")
            return Link(
                receiver ?: Receiver.discover(MulticastBrowser()),
                TransportSecurity.Insecure(insecureEyeImages),
            )
        }
        val keys = openKeys()
        val paired = failing(EXIT_USAGE) { keys.receivers }
        if (paired.isEmpty()) {
            throw UsageError("paired with no receiver: run ml2-receiver pair there, then ml2-headset --pair URI")
        }
        return Link(receiver ?: keys.receiver(MulticastBrowser()), keys.security())
    }

    private fun openKeys(): DeviceKeys = failing(EXIT_USAGE) { KeyFolder(keys).open(NAME) }

    private inline fun <T> failing(exitCode: Int, action: () -> T): T = try {
        action()
    } catch (failure: IOException) {
        throw PrintMessage("Error: ${failure.message}", exitCode, printError = true)
    }

    private companion object {
        const val NAME = "ml2-headset"
        const val EXIT_FAILED = 1
    }
}

private inline fun <T> OptionCallTransformContext.parsing(action: () -> T): T = try {
    action()
} catch (mistake: IllegalArgumentException) {
    fail(mistake.message.orEmpty())
}
