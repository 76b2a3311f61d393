package dev.ml2sensors.pairing

import dev.ml2sensors.session.Receiver
import dev.ml2sensors.session.ReceiverBrowser
import dev.ml2sensors.source.Headset
import dev.ml2sensors.transport.DeviceIdentity
import dev.ml2sensors.transport.TlsClient
import dev.ml2sensors.transport.TransportException
import dev.ml2sensors.transport.TransportSecurity
import kotlinx.coroutines.Dispatchers
import kotlinx.coroutines.NonCancellable
import kotlinx.coroutines.withContext
import java.io.File
import java.io.IOException

/**
 * The device's identity and the receivers that it is paired with. Thread-safe. Files and key stores are read when
 * needed: by [identity] and [receivers] on the caller's thread, otherwise on a thread that may block.
 *
 * @param receiversFile stores the receivers and nothing secret; need not exist yet.
 */
internal class DeviceKeys internal constructor(identity: Lazy<DeviceIdentity>, receiversFile: File) {
    constructor(identity: DeviceIdentity, receiversFile: File) : this(lazyOf(identity), receiversFile)

    private val store = ReceiverStore(receiversFile)

    /**
     * The identity of this device.
     *
     * @throws IOException when the platform's key store fails.
     */
    val identity: DeviceIdentity by identity

    /**
     * The receivers that this device is paired with, the latest one last.
     *
     * @throws IOException when the file cannot be read or is damaged.
     */
    val receivers: List<PairedReceiver> get() = store.load()

    /** Returns TLS with the [receivers] that are known when the first connection is made. */
    fun security(): TransportSecurity.Paired =
        TransportSecurity.Paired { TlsClient(identity, receivers.map { it.fingerprint }.toSet()) }

    /**
     * Returns a receiver that resolves, for each connection, to a paired one that announces itself, or else to the last
     * known address of the latest one. While the device is not paired, resolving fails.
     */
    fun receiver(browser: ReceiverBrowser): Receiver = PairedReceiverLocator(store::load, browser)

    /**
     * Pairs with the receiver that showed [uri], and stores it. Does not block the caller's thread.
     *
     * @param device the id and name under which the receiver stores this device.
     * @throws PairingException when the receiver refuses or does not answer.
     * @throws TransportException when another machine answers, or without TLS 1.3.
     * @throws IOException when the key store fails, or the receiver cannot be stored.
     */
    suspend fun pair(uri: PairingUri, device: Headset.Identity): PairedReceiver {
        val identity = withContext(Dispatchers.IO) { identity }
        val paired = PairingExchange(identity, device).run(uri)
        // The receiver knows this device from here on
        withContext(NonCancellable + Dispatchers.IO) { store.add(paired) }
        return paired
    }
}
