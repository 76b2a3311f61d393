package dev.ml2sensors.android

import android.security.keystore.KeyGenParameterSpec
import dev.ml2sensors.transport.DeviceIdentity
import java.io.File
import java.io.InputStream
import java.io.OutputStream
import java.security.Key
import java.security.KeyPair
import java.security.KeyPairGeneratorSpi
import java.security.KeyStore
import java.security.KeyStoreSpi
import java.security.PrivateKey
import java.security.Provider
import java.security.SecureRandom
import java.security.Security
import java.security.UnrecoverableKeyException
import java.security.cert.Certificate
import java.security.spec.AlgorithmParameterSpec
import java.util.Collections
import java.util.Date
import java.util.Enumeration
import java.util.concurrent.CountDownLatch

/**
 * What Robolectric lacks: the provider `AndroidKeyStore`, with keys that are made for one [made] specification each.
 */
internal class FakeKeystore : Provider("AndroidKeyStore", "1", "in memory") {
    private val content = HashMap<String, Pair<PrivateKey, Certificate>>()
    val made = ArrayList<KeyGenParameterSpec>()

    /** True while the keys that were made so far are listed but cannot be read. */
    var isUnreadable = false

    /** What is awaited before it says whether there is a key. */
    @Volatile
    var answer: CountDownLatch? = null

    /** Holds the key of [identity] as [alias] from the start. */
    fun add(alias: String, identity: DeviceIdentity) {
        content[alias] = identity.privateKey to identity.certificate
    }

    init {
        putService(service("KeyStore", "AndroidKeyStore") { Store() })
        putService(service("KeyPairGenerator", "EC") { Generator() })
    }

    /** Runs [test] with this provider. */
    fun use(test: () -> Unit) {
        Security.addProvider(this)
        try {
            test()
        } finally {
            Security.removeProvider(name)
        }
    }

    private fun service(type: String, algorithm: String, make: () -> Any) =
        object : Service(this, type, algorithm, "none", null, null) {
            override fun newInstance(parameter: Any?) = make()
        }

    /** A key and its certificate by the JDK's tool. */
    private fun keytool(subject: String): Pair<PrivateKey, Certificate> {
        val file = File.createTempFile("key", ".p12").apply { delete() }
        val arguments = listOf(
            "${System.getProperty("java.home")}/bin/keytool", "-genkeypair", "-alias", "key", "-keyalg", "EC",
            "-groupname", "secp256r1", "-dname", subject, "-storetype", "PKCS12", "-keystore", file.path,
            "-storepass", "changeit",
        )
        val process = ProcessBuilder(arguments).redirectErrorStream(true).start()
        val output = process.inputStream.bufferedReader().readText()
        check(process.waitFor() == 0) { output }
        val password = "changeit".toCharArray()
        val store = KeyStore.getInstance(file, password)
        file.delete()
        return store.getKey("key", password) as PrivateKey to store.getCertificate("key")
    }

    private inner class Generator : KeyPairGeneratorSpi() {
        private lateinit var specification: KeyGenParameterSpec

        override fun initialize(parameters: AlgorithmParameterSpec, random: SecureRandom?) {
            specification = parameters as KeyGenParameterSpec
        }

        override fun initialize(size: Int, random: SecureRandom?) = error("without a specification")

        override fun generateKeyPair(): KeyPair {
            val (key, certificate) = keytool(specification.certificateSubject.name)
            content[specification.keystoreAlias] = key to certificate
            made += specification
            isUnreadable = false
            return KeyPair(certificate.publicKey, key)
        }
    }

    private inner class Store : KeyStoreSpi() {
        override fun engineLoad(stream: InputStream?, password: CharArray?) = Unit

        override fun engineGetKey(alias: String, password: CharArray?): Key? {
            if (isUnreadable) throw UnrecoverableKeyException("Failed to obtain information about key")
            return content[alias]?.first
        }

        override fun engineGetCertificate(alias: String): Certificate? = content[alias]?.second

        override fun engineContainsAlias(alias: String): Boolean = alias in content

        override fun engineIsKeyEntry(alias: String): Boolean {
            answer?.await()
            return alias in content
        }

        override fun engineSize(): Int = content.size

        override fun engineAliases(): Enumeration<String> = Collections.enumeration(content.keys)

        override fun engineGetCertificateChain(alias: String) = error("not asked for")

        override fun engineGetCreationDate(alias: String): Date = error("not asked for")

        override fun engineSetKeyEntry(a: String?, k: Key?, p: CharArray?, c: Array<out Certificate>?) = error("never")

        override fun engineSetKeyEntry(a: String?, k: ByteArray?, c: Array<out Certificate>?) = error("never")

        override fun engineSetCertificateEntry(a: String?, c: Certificate?) = error("never")

        override fun engineDeleteEntry(a: String?) = error("never")

        override fun engineIsCertificateEntry(alias: String): Boolean = false

        override fun engineGetCertificateAlias(certificate: Certificate?): String? = null

        override fun engineStore(stream: OutputStream?, password: CharArray?) = error("never")
    }
}
