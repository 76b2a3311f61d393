package dev.ml2sensors.wire

import kotlinx.serialization.SerialName
import kotlinx.serialization.Serializable

// The JSON bodies of PROTOCOL.md, Pairing.

@Serializable
internal class PairChallenge(val nonce: String, val name: String, val software: String) {
    init {
        require(NONCE.matches(nonce)) { "nonce: expected $NONCE" }
        violation(name, software)?.let { throw IllegalArgumentException(it) }
    }
}

private val NONCE = Regex("[0-9a-f]{64}")

/** @property certificate DER in base64, like the [signature]. */
@Serializable
internal class PairBody(
    val token: String,
    val name: String,
    @SerialName("device_id") val deviceId: String,
    val certificate: String,
    val signature: String,
)

/** @property port where the receiver serves sessions. */
@Serializable
internal class Paired(val name: String, val port: Int) {
    init {
        require(port in 1..65535) { "port: expected 1 to 65535" }
        violation(name)?.let { throw IllegalArgumentException(it) }
    }
}
