package dev.ml2sensors.transport

import dev.ml2sensors.TEST_LIMIT
import java.io.Closeable
import java.io.IOException
import java.net.InetAddress
import java.net.InetSocketAddress
import java.net.Socket
import java.security.Principal
import java.security.cert.CertificateException
import java.security.cert.X509Certificate
import java.util.concurrent.CompletableFuture
import java.util.concurrent.TimeUnit
import java.util.concurrent.atomic.AtomicInteger
import javax.net.ssl.KeyManager
import javax.net.ssl.SSLContext
import javax.net.ssl.SSLServerSocket
import javax.net.ssl.SSLSocket
import javax.net.ssl.X509ExtendedKeyManager
import javax.net.ssl.X509TrustManager
import kotlin.concurrent.thread

/** A receiver's end of TLS by the JDK's own sockets, for one [script] per connection. */
internal class TlsPeer(
    private val protocols: List<String> = listOf("TLSv1.3"),
    applicationProtocols: List<String> = listOf("ml2s/1"),
    trusted: DeviceIdentity = TestIdentity.device,
    needsCertificate: Boolean = true,
    private val script: (SSLSocket) -> Unit,
) : Closeable {
    /** The number of times that a device has shown its certificate; it does not when it resumes. */
    val certificatesSeen = AtomicInteger()

    private val trust = trusting(trusted) { certificatesSeen.incrementAndGet() }
    private val server = serverSocket(trust, protocols, applicationProtocols).apply {
        if (!needsCertificate) needClientAuth = false
        bind(InetSocketAddress(InetAddress.getLoopbackAddress(), 0))
    }

    /** The failure of the last connection's script; null if it ended well. */
    private var outcome = CompletableFuture<Throwable?>()
    val port: Int get() = server.localPort

    init {
        thread(isDaemon = true) {
            while (true) {
                val socket = try {
                    server.accept() as SSLSocket
                } catch (_: IOException) {
                    break
                }
                thread(isDaemon = true) { serve(socket) }
            }
        }
    }

    private fun serve(socket: SSLSocket) {
        val failure = runCatching { socket.use(script) }.exceptionOrNull()
        synchronized(this) { outcome }.complete(failure)
    }

    /** Awaits the end of the script, for each connection in turn; returns its failure, or null if it ended well. */
    fun awaitOutcome(): Throwable? {
        val failure = synchronized(this) { outcome }.get(TEST_LIMIT.inWholeMilliseconds, TimeUnit.MILLISECONDS)
        synchronized(this) { outcome = CompletableFuture() }
        return failure
    }

    override fun close(): Unit = server.close()

    companion object {

        fun trusting(device: DeviceIdentity, seen: () -> Unit = {}) = object : X509TrustManager {
            override fun checkClientTrusted(chain: Array<X509Certificate>, authType: String) {
                seen()
                if (chain.single() != device.certificate) throw CertificateException("not paired")
            }

            override fun checkServerTrusted(chain: Array<X509Certificate>, authType: String) = error("a server's end")

            override fun getAcceptedIssuers(): Array<X509Certificate> = emptyArray()
        }

        /** Not yet bound; asks for a certificate of the device. */
        fun serverSocket(
            trust: X509TrustManager,
            protocols: List<String> = listOf("TLSv1.3"),
            applicationProtocols: List<String> = listOf("ml2s/1"),
        ): SSLServerSocket {
            val context = SSLContext.getInstance("TLS")
            context.init(arrayOf<KeyManager>(ServerKeys), arrayOf(trust), null)
            return (context.serverSocketFactory.createServerSocket() as SSLServerSocket).apply {
                needClientAuth = true
                enabledProtocols = protocols.toTypedArray()
                sslParameters = sslParameters.apply { this.applicationProtocols = applicationProtocols.toTypedArray() }
            }
        }
    }

    private object ServerKeys : X509ExtendedKeyManager() {
        private const val ALIAS = "receiver"

        override fun getCertificateChain(alias: String?) = arrayOf(TestIdentity.receiver.certificate)

        override fun getPrivateKey(alias: String?) = TestIdentity.receiver.privateKey

        override fun getClientAliases(keyType: String?, issuers: Array<Principal>?) = null

        override fun chooseClientAlias(
            keyType: Array<String>?,
            issuers: Array<Principal>?,
            socket: Socket?,
        ) = null

        override fun getServerAliases(keyType: String?, issuers: Array<Principal>?) = arrayOf(ALIAS)

        override fun chooseServerAlias(keyType: String?, issuers: Array<Principal>?, socket: Socket?) =
            ALIAS.takeIf { keyType == "EC" }
    }
}
