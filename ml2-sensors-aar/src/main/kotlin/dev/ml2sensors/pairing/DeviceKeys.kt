package dev.ml2sensors.pairing

import dev.ml2sensors.link.DeviceIdentity
import dev.ml2sensors.link.LinkException
import dev.ml2sensors.link.LinkSecurity
import dev.ml2sensors.session.Receiver
import dev.ml2sensors.session.ReceiverBrowser
import dev.ml2sensors.source.Headset
import java.io.File
import java.io.IOException

/**
 * What a device has to be let in: who it is, and the receivers it is paired with.
 *
 * @param receiversFile keeps the latter; nothing in it is secret. May not exist yet.
 */
public class DeviceKeys(public val identity: DeviceIdentity, receiversFile: File) {
    private val store = ReceiverStore(receiversFile)

    /**
     * The receivers that this device is paired with, the last one last.
     *
     * @throws IOException when the file cannot be read or is damaged.
     */
    public val receivers: List<PairedReceiver> get() = store.load()

    /** TLS with those [receivers] there are now. */
    public fun security(): LinkSecurity.Paired =
        LinkSecurity.Paired(identity, receivers.map { it.fingerprint }.toSet())

    /**
     * One of the [receivers] there are now: one that announces itself, else the last one where it was paired.
     *
     * @throws IllegalArgumentException when there is none.
     */
    public fun receiver(browser: ReceiverBrowser): Receiver = KnownReceiver(receivers, browser)

    /**
     * Pairs with the receiver that showed [uri], and remembers it. Blocks no thread of the caller's.
     *
     * @param device as what the receiver will know this one.
     * @throws PairingException when the receiver refuses or does not answer.
     * @throws LinkException when another machine answers, or without TLS 1.3.
     * @throws IOException when it cannot be remembered.
     */
    public suspend fun pair(uri: PairingUri, device: Headset.Identity): PairedReceiver =
        PairingExchange(identity, device).run(uri).also(store::add)
}
