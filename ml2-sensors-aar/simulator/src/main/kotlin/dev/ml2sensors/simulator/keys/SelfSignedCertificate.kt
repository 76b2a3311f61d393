package dev.ml2sensors.simulator.keys

import java.math.BigInteger
import java.security.KeyPair
import java.security.SecureRandom
import java.security.Signature
import java.security.cert.CertificateFactory
import java.security.cert.X509Certificate

/**
 * Returns a self-signed certificate (RFC 5280) for [keys], an EC pair: version 3, subject and issuer CN=[name], valid
 * from 2000 to the last second of 9999, ECDSA with SHA-256, no extensions. Java has no public API for this.
 */
internal fun selfSignedCertificate(keys: KeyPair, name: String): X509Certificate {
    val commonName = sequence(set(sequence(COMMON_NAME, der(UTF8_STRING, name.toByteArray()))))
    val body = sequence(
        der(EXPLICIT_0, integer(BigInteger.TWO)),
        integer(BigInteger(SERIAL_BITS, SecureRandom()).setBit(0)),
        ECDSA_WITH_SHA256,
        commonName,
        sequence(der(UTC_TIME, "000101000000Z".toByteArray()), der(GENERALIZED_TIME, "99991231235959Z".toByteArray())),
        commonName,
        keys.public.encoded,
    )
    val signature = Signature.getInstance("SHA256withECDSA").run {
        initSign(keys.private)
        update(body)
        sign()
    }
    val certificate = sequence(body, ECDSA_WITH_SHA256, der(BIT_STRING, byteArrayOf(0) + signature))
    return CertificateFactory.getInstance("X.509").generateCertificate(certificate.inputStream()) as X509Certificate
}

private const val SERIAL_BITS = 127

// Tags of X.690.
private const val INTEGER = 0x02
private const val BIT_STRING = 0x03
private const val UTF8_STRING = 0x0C
private const val UTC_TIME = 0x17
private const val GENERALIZED_TIME = 0x18
private const val SEQUENCE = 0x30
private const val SET = 0x31
private const val EXPLICIT_0 = 0xA0

/** OBJECT IDENTIFIER 2.5.4.3. */
private val COMMON_NAME = byteArrayOf(0x06, 3, 0x55, 0x04, 0x03)

/** AlgorithmIdentifier of OBJECT IDENTIFIER 1.2.840.10045.4.3.2, RFC 5758. */
private val ECDSA_WITH_SHA256 =
    sequence(byteArrayOf(0x06, 8, 0x2A, 0x86.toByte(), 0x48, 0xCE.toByte(), 0x3D, 0x04, 0x03, 0x02))

private fun integer(value: BigInteger) = der(INTEGER, value.toByteArray())

private fun sequence(vararg parts: ByteArray) = der(SEQUENCE, *parts)

private fun set(part: ByteArray) = der(SET, part)

/** Returns a DER element: tag, length and contents (X.690, 8.1). */
private fun der(tag: Int, vararg parts: ByteArray): ByteArray {
    val size = parts.sumOf { it.size }
    val length = BigInteger.valueOf(size.toLong()).toByteArray().dropWhile { it == 0.toByte() }.toByteArray()
    val head = if (size < 0x80) byteArrayOf(size.toByte()) else byteArrayOf((0x80 + length.size).toByte()) + length
    return parts.fold(byteArrayOf(tag.toByte()) + head, ByteArray::plus)
}
