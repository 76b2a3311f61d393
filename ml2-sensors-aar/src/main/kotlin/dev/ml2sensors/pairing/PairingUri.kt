package dev.ml2sensors.pairing

import dev.ml2sensors.session.ReceiverAddress
import dev.ml2sensors.transport.Fingerprint

/**
 * The URI that `ml2-receiver pair` shows: `ml2s://HOST:PORT?fp=FINGERPRINT&token=TOKEN`, an IPv6 address in brackets.
 *
 * @property receiver the address of the pairing service, with the fingerprint that its certificate must have.
 * @property token pairs one device, once; secret until then.
 */
public class PairingUri private constructor(public val receiver: ReceiverAddress, internal val token: String) {
    internal val fingerprint: Fingerprint get() = checkNotNull(receiver.fingerprint)

    /** Returns the URI without the token. */
    override fun toString(): String = "ml2s://$receiver?fp=$fingerprint"

    public companion object {
        private val FORM = Regex(
            """ml2s://(?:\[([0-9A-Fa-f:.]{2,45})]|([A-Za-z0-9.-]{1,253})):([1-9][0-9]{0,4})""" +
                """\?fp=([0-9a-f]{64})&token=([0-9a-f]{32})""",
        )

        /**
         * Parses [text].
         *
         * @throws IllegalArgumentException if it is not a pairing URI; the message does not repeat it, since it may be
         * secret.
         */
        public fun parse(text: String): PairingUri {
            val (bracketed, plain, port, fingerprint, token) = requireNotNull(FORM.matchEntire(text)) {
                "expected ml2s://HOST:PORT?fp=64_HEX_DIGITS&token=32_HEX_DIGITS, as ml2-receiver pair shows it, " +
                    "found ${text.length} other characters"
            }.destructured
            require(bracketed.isEmpty() || ':' in bracketed) { "expected an IPv6 address in brackets" }
            val host = bracketed.ifEmpty { plain }
            return PairingUri(ReceiverAddress(host, port.toInt(), Fingerprint(fingerprint)), token)
        }
    }
}
