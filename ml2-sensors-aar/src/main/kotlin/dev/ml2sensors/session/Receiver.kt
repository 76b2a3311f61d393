package dev.ml2sensors.session

import dev.ml2sensors.transport.Fingerprint
import kotlinx.coroutines.flow.Flow
import java.io.IOException

/** A receiver to stream to: a [ReceiverAddress], or one that is found by name. */
public interface Receiver {
    /**
     * Returns the address on which it listens now; called for every connection, from any thread.
     *
     * @throws IOException when it is not found; the message says what was found instead.
     */
    public suspend fun locate(): ReceiverAddress

    public companion object {
        /**
         * Returns the receiver that announces itself as [name], found with [browser]; without a name, the only one. A
         * search without a name fails if there are several, and lists them.
         */
        public fun discover(browser: ReceiverBrowser, name: String? = null): Receiver =
            DiscoveredReceiver(browser, name)

        /**
         * Parses a name or `HOST:PORT`, an IPv6 address in brackets; an empty [text] means the only receiver.
         *
         * @throws IllegalArgumentException for anything else; the message does not repeat a pairing URI, which is
         * secret.
         */
        public fun parse(text: String, browser: ReceiverBrowser): Receiver = when {
            text.isEmpty() -> discover(browser)

            text.contains("ml2s:", ignoreCase = true) -> throw IllegalArgumentException(
                "$EXPECTED; a URI of ml2-receiver pair is for pairing only",
            )

            ':' in text -> address(text)

            else -> discover(browser, text)
        }

        private fun address(text: String): ReceiverAddress {
            val (bracketed, plain, port) = HOST_AND_PORT.matchEntire(text)?.destructured ?: fail(text)
            val number = port.toInt().takeIf { it in 1..65535 } ?: fail(text)
            return ReceiverAddress(bracketed.ifEmpty { plain }, number)
        }

        private fun fail(text: String): Nothing = throw IllegalArgumentException("$EXPECTED, found '$text'")

        private const val EXPECTED = "expected a name, or HOST:PORT with a port of 1 to 65535"
        private val HOST_AND_PORT = Regex("""(?:\[([^]/]+)]|([^:/\[]+)):(\d{1,5})""")
    }
}

/**
 * The address of a receiver.
 *
 * @property host a name, or an address without brackets.
 * @property port 1 to 65535.
 * @property fingerprint the fingerprint that its certificate must have; null for any that this device is paired with.
 */
public data class ReceiverAddress(val host: String, val port: Int, val fingerprint: Fingerprint? = null) : Receiver {
    init {
        require(host.isNotEmpty()) { "a receiver's host is empty" }
        require(port in 1..65535) { "a receiver's port is 1 to 65535, not $port" }
    }

    override suspend fun locate(): ReceiverAddress = this

    override fun toString(): String = if (':' in host) "[$host]:$port" else "$host:$port"
}

/** Finds receivers on the local networks: DNS-SD over mDNS, implemented by the platform. */
public fun interface ReceiverBrowser {
    /**
     * Emits the present receivers by name, with the fingerprints that they announce, whenever they change. Each
     * collection starts a search and ends it. Fails with a [java.io.IOException] if searching is impossible.
     */
    public fun receivers(): Flow<Map<String, ReceiverAddress>>

    public companion object {
        /** The type of the service, without a domain. */
        public const val SERVICE_TYPE: String = "_ml2sensors._tcp"

        /** The key of the TXT record whose value is the fingerprint of the receiver's certificate. */
        public const val FINGERPRINT_KEY: String = "fp"
    }
}
