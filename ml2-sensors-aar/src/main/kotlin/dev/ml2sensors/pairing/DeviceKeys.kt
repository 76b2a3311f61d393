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
 * What a device has to be let in: who it is, and the receivers it is paired with. Any thread; files and key stores are
 * read when they are needed, by [identity] and [receivers] on the caller's thread, else on one that may block.
 *
 * @param receiversFile keeps the receivers; nothing in it is secret. May not exist yet.
 */
public class DeviceKeys internal constructor(identity: Lazy<DeviceIdentity>, receiversFile: File) {
    public constructor(identity: DeviceIdentity, receiversFile: File) : this(lazyOf(identity), receiversFile)

    private val store = ReceiverStore(receiversFile)

    /** @throws IOException when the platform's key store fails. */
    public val identity: DeviceIdentity by identity

    /**
     * The receivers that this device is paired with, the last one last.
     *
     * @throws IOException when the file cannot be read or is damaged.
     */
    public val receivers: List<PairedReceiver> get() = store.load()

    /** TLS with those [receivers] that there are when the first connection is made. */
    public fun security(): TransportSecurity.Paired =
        TransportSecurity.Paired { TlsClient(identity, receivers.map { it.fingerprint }.toSet()) }

    /**
     * One of the [receivers] that there are when a connection is made: one that announces itself, else the last one
     * where it was paired. While there is none, it is not found.
     */
    public fun receiver(browser: ReceiverBrowser): Receiver = PairedReceiverLocator(store::load, browser)

    /**
     * Pairs with the receiver that showed [uri], and remembers it. Blocks no thread of the caller's.
     *
     * @param device as what the receiver will know this one.
     * @throws PairingException when the receiver refuses or does not answer.
     * @throws TransportException when another machine answers, or without TLS 1.3.
     * @throws IOException when the key store fails, or it cannot be remembered.
     */
    public suspend fun pair(uri: PairingUri, device: Headset.Identity): PairedReceiver {
        val identity = withContext(Dispatchers.IO) { identity }
        val paired = PairingExchange(identity, device).run(uri)
        // The receiver knows this device from here on
        withContext(NonCancellable + Dispatchers.IO) { store.add(paired) }
        return paired
    }
}
