package dev.ml2sensors.transport

import java.net.Socket
import java.security.cert.CertificateException
import java.security.cert.X509Certificate
import javax.net.ssl.SSLEngine
import javax.net.ssl.X509ExtendedTrustManager

/** Trusts a receiver's certificate if it is one of [pinned]. Names, dates and chains are not checked. */
internal class PinnedTrust(private val pinned: Set<Fingerprint>) : X509ExtendedTrustManager() {
    override fun checkServerTrusted(chain: Array<X509Certificate>, authType: String) {
        val found = Fingerprint.of(chain.first())
        if (found !in pinned) throw UnpinnedException(found)
    }

    override fun checkServerTrusted(chain: Array<X509Certificate>, authType: String, socket: Socket?) =
        checkServerTrusted(chain, authType)

    override fun checkServerTrusted(chain: Array<X509Certificate>, authType: String, engine: SSLEngine?) =
        checkServerTrusted(chain, authType)

    override fun checkClientTrusted(chain: Array<X509Certificate>, authType: String) = refuseClients()

    override fun checkClientTrusted(chain: Array<X509Certificate>, authType: String, socket: Socket?) = refuseClients()

    override fun checkClientTrusted(chain: Array<X509Certificate>, authType: String, engine: SSLEngine?) =
        refuseClients()

    override fun getAcceptedIssuers(): Array<X509Certificate> = emptyArray()

    private fun refuseClients(): Nothing = throw CertificateException("a device accepts no clients")
}

/** The server's certificate has the fingerprint [found], which is not pinned. */
internal class UnpinnedException(val found: Fingerprint) : CertificateException("not pinned: $found")
