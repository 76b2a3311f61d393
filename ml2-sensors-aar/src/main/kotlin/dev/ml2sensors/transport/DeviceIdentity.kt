package dev.ml2sensors.transport

import java.io.IOException
import java.security.GeneralSecurityException
import java.security.PrivateKey
import java.security.Signature
import java.security.cert.X509Certificate

/**
 * Who the device is to its receivers: an EC P-256 key of its own, and a certificate that this key has signed.
 *
 * @property certificate of the key, signed by itself.
 * @param privateKey may be one that cannot be read, of a key store; it signs SHA-256 digests and what is one already.
 */
public class DeviceIdentity(internal val privateKey: PrivateKey, public val certificate: X509Certificate) {
    init {
        require(privateKey.algorithm == "EC") { "a device's key is an EC key, not ${privateKey.algorithm}" }
    }

    /** Of the [certificate]: by it receivers know the device. */
    public val fingerprint: Fingerprint = Fingerprint.of(certificate)

    /**
     * ECDSA with SHA-256, in DER.
     *
     * @throws IOException when the key store fails.
     */
    internal fun sign(message: ByteArray): ByteArray = try {
        Signature.getInstance("SHA256withECDSA").run {
            initSign(privateKey)
            update(message)
            sign()
        }
    } catch (e: GeneralSecurityException) {
        throw IOException("the device's key does not sign: ${e.message}", e)
    }
}
