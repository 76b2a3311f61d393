package dev.ml2sensors.transport

import java.security.MessageDigest
import java.security.cert.X509Certificate

/** The SHA-256 digest of a certificate's DER bytes: [hex], 64 lower-case hexadecimal digits. */
public data class Fingerprint(public val hex: String) {
    init {
        require(FORM.matches(hex)) { "a fingerprint is 64 lower-case hexadecimal digits, not '$hex'" }
    }

    override fun toString(): String = hex

    public companion object {
        private val FORM = Regex("[0-9a-f]{64}")

        internal fun of(certificate: X509Certificate): Fingerprint {
            val digest = MessageDigest.getInstance("SHA-256").digest(certificate.encoded)
            return Fingerprint(digest.joinToString("") { "%02x".format(it) })
        }

        /** Returns the fingerprint in [text], or null if it is not one. */
        public fun orNull(text: String?): Fingerprint? = text?.takeIf(FORM::matches)?.let(::Fingerprint)
    }
}
