package dev.ml2sensors.transport

import java.nio.file.Files
import java.nio.file.Path
import java.security.KeyStore
import java.security.PrivateKey
import java.security.cert.X509Certificate
import kotlin.test.assertEquals

/** Identities that the JDK's keytool has made. */
internal object TestIdentity {
    private const val PASSWORD = "changeit"

    val device: DeviceIdentity by lazy { make("device") }
    val receiver: DeviceIdentity by lazy { make("receiver") }
    val other: DeviceIdentity by lazy { make("other") }

    private fun make(name: String): DeviceIdentity {
        val folder = Files.createTempDirectory("keys")
        val file = folder.resolve("$name.p12")
        val arguments = listOf(
            Path.of(System.getProperty("java.home"), "bin", "keytool").toString(),
            "-genkeypair", "-alias", name, "-keyalg", "EC", "-groupname", "secp256r1", "-dname", "CN=$name",
            "-storetype", "PKCS12", "-keystore", "$file", "-storepass", PASSWORD,
        )
        val process = ProcessBuilder(arguments).redirectErrorStream(true).start()
        val output = process.inputStream.bufferedReader().readText()
        assertEquals(0, process.waitFor(), output)
        val store = KeyStore.getInstance(file.toFile(), PASSWORD.toCharArray())
        folder.toFile().deleteRecursively()
        return DeviceIdentity(
            store.getKey(name, PASSWORD.toCharArray()) as PrivateKey,
            store.getCertificate(name) as X509Certificate,
        )
    }
}
