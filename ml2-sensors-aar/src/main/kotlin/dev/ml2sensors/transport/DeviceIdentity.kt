package dev.ml2sensors.transport

import java.io.IOException
import java.security.PrivateKey
import java.security.Signature
import java.security.cert.X509Certificate

/**
 * The identity of the device: an EC P-256 key of its own and a certificate signed with it.
 *
 * @property certificate the self-signed certificate of the key.
 * @param privateKey need not be exportable from its key store; it signs SHA-256 digests.
 */
internal class DeviceIdentity(internal val privateKey: PrivateKey, val certificate: X509Certificate) {
    init {
        require(privateKey.algorithm == "EC") { "a device's key is an EC key, not ${privateKey.algorithm}" }
    }

    /** The fingerprint of the [certificate], by which receivers know the device. */
    val fingerprint: Fingerprint = Fingerprint.of(certificate)

    /**
     * Returns the ECDSA signature with SHA-256 of [message], in DER.
     *
     * @throws IOException when the key store fails.
     */
    internal fun sign(message: ByteArray): ByteArray = try {
        Signature.getInstance("SHA256withECDSA").run {
            initSign(privateKey)
            update(message)
            sign()
        }
    } catch (e: Exception) { // Key stores throw more kinds than are documented
        throw IOException("signing with the device's key failed: ${e.message ?: e.javaClass.simpleName}", e)
    }
}
