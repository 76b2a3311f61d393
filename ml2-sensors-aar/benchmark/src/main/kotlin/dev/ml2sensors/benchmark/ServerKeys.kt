package dev.ml2sensors.benchmark

import dev.ml2sensors.transport.Fingerprint
import dev.ml2sensors.transport.TlsClient
import dev.ml2sensors.transport.TransportChannel
import java.nio.file.Path
import java.security.KeyStore
import java.security.cert.X509Certificate
import javax.net.ssl.KeyManagerFactory
import javax.net.ssl.SSLContext
import javax.net.ssl.SSLSocket
import kotlin.concurrent.thread
import kotlin.io.path.createTempDirectory

/** A receiver's key, by the JDK's keytool. */
internal class ServerKeys {
    private val store = keytool()
    private val context = SSLContext.getInstance("TLSv1.3").apply {
        val keys = KeyManagerFactory.getInstance("SunX509")
        keys.init(store, PASSWORD.toCharArray())
        init(keys.keyManagers, null, null)
    }
    val fingerprint: Fingerprint = Fingerprint.of(store.getCertificate(ALIAS) as X509Certificate)

    /** Has [client] and the peer of [sink] agree on keys. */
    fun secure(sink: LoopbackSink, client: TlsClient): TransportChannel {
        val peer = thread {
            val socket = sink.peer.socket()
            val server = context.socketFactory.createSocket(socket, "localhost", socket.port, false) as SSLSocket
            server.useClientMode = false
            server.sslParameters = server.sslParameters.apply { applicationProtocols = arrayOf("ml2s/1") }
            server.startHandshake()
        }
        return client.open(sink.channel, "loopback").also { peer.join() }
    }

    private fun keytool(): KeyStore {
        val file = createTempDirectory("keys").resolve("server.p12")
        val tool = Path.of(System.getProperty("java.home"), "bin", "keytool").toString()
        val arguments = listOf(
            tool, "-genkeypair", "-alias", ALIAS, "-keyalg", "EC", "-groupname", "secp256r1", "-dname", "CN=bench",
            "-storetype", "PKCS12", "-keystore", "$file", "-storepass", PASSWORD,
        )
        check(ProcessBuilder(arguments).inheritIO().start().waitFor() == 0) { "keytool failed" }
        return KeyStore.getInstance(file.toFile(), PASSWORD.toCharArray())
    }

    private companion object {
        const val ALIAS = "server"
        const val PASSWORD = "changeit"
    }
}
