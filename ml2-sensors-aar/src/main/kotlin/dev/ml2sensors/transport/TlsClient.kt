package dev.ml2sensors.transport

import java.net.InetSocketAddress
import java.nio.channels.SocketChannel
import java.security.Provider
import java.security.cert.X509Certificate
import javax.net.ssl.SSLContext
import javax.net.ssl.SSLEngine
import javax.net.ssl.SSLException

/**
 * The device's side of TLS 1.3. Keeps the receivers' session tickets, so that lanes after the first connect quickly.
 *
 * @param identity null presents no certificate, as in pairing.
 * @param pinned the certificates that a receiver may have.
 * @param provider of TLS, null for the platform's.
 */
internal class TlsClient(
    identity: DeviceIdentity?,
    private val pinned: Set<Fingerprint>,
    provider: Provider? = null,
) {
    init {
        if (pinned.isEmpty()) throw NotPairedException("any receiver")
    }

    private val context =
        (if (provider == null) SSLContext.getInstance(TLS) else SSLContext.getInstance(TLS, provider)).apply {
            init(identity?.let { arrayOf(IdentityKeys(it)) }, arrayOf(PinnedTrust(pinned)), null)
        }

    /**
     * Runs TLS on a connected [socket], which the channel then owns.
     *
     * @param receiver its address, for messages.
     * @param expected the pinned certificate that it must have; null for any of them.
     * @throws TransportException when this is not such a receiver.
     */
    fun open(socket: SocketChannel, receiver: String, expected: Fingerprint? = null): TransportChannel {
        val engine = engine(socket.remoteAddress as InetSocketAddress)
        val channel = TlsChannel(socket, engine, receiver)
        try {
            channel.handshake()
            check(engine, receiver, if (expected == null) pinned else setOf(expected))
            return channel
        } catch (e: SSLException) {
            channel.close()
            throw explained(e, receiver)
        } catch (e: Throwable) {
            channel.close()
            throw e
        }
    }

    /** Returns an engine for the address as a number, since a name would be sent unencrypted. */
    private fun engine(peer: InetSocketAddress): SSLEngine =
        context.createSSLEngine(peer.address.hostAddress, peer.port).apply {
            useClientMode = true
            sslParameters = sslParameters.apply {
                protocols = arrayOf(TLS)
                applicationProtocols = arrayOf(APPLICATION_PROTOCOL)
            }
        }

    /** Checks the certificate: a resumed session has shown none to [PinnedTrust], but remembers that of the first. */
    private fun check(engine: SSLEngine, receiver: String, trusted: Set<Fingerprint>) {
        val found = Fingerprint.of(engine.session.peerCertificates.first() as X509Certificate)
        if (found !in trusted || found !in pinned) throw WrongReceiverException(receiver, trusted, found)
        if (engine.applicationProtocol != APPLICATION_PROTOCOL) {
            throw TlsException(receiver, "a server of '${engine.applicationProtocol}' instead of $APPLICATION_PROTOCOL")
        }
    }

    private fun explained(failure: SSLException, receiver: String): TransportException {
        val causes = generateSequence<Throwable>(failure) { it.cause }
        val unpinned = causes.filterIsInstance<UnpinnedException>().firstOrNull()
        return if (unpinned == null) {
            TlsException(receiver, failure.message ?: failure.javaClass.simpleName, failure)
        } else {
            WrongReceiverException(receiver, pinned, unpinned.found)
        }
    }

    private companion object {
        const val TLS = "TLSv1.3"
        const val APPLICATION_PROTOCOL = "ml2s/1"
    }
}
