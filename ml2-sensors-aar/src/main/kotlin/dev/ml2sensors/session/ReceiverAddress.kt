package dev.ml2sensors.session

import dev.ml2sensors.transport.Fingerprint

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
