package dev.ml2sensors.android

import android.security.keystore.KeyGenParameterSpec
import dev.ml2sensors.transport.DeviceIdentity
import dev.ml2sensors.transport.TestIdentity
import java.io.InputStream
import java.io.OutputStream
import java.security.Key
import java.security.KeyPair
import java.security.KeyPairGeneratorSpi
import java.security.KeyStoreSpi
import java.security.PrivateKey
import java.security.Provider
import java.security.PublicKey
import java.security.SecureRandom
import java.security.Security
import java.security.Signature
import java.security.SignatureSpi
import java.security.cert.Certificate
import java.security.spec.AlgorithmParameterSpec
import java.util.Collections
import java.util.Date
import java.util.Enumeration
import java.util.concurrent.ConcurrentHashMap
import java.util.concurrent.CopyOnWriteArrayList

/**
 * The provider `AndroidKeyStore`, which Robolectric lacks. Its keys sign, but do not leave it. It generates those of
 * [TestIdentity] in turn, since each key of its own would take a second.
 */
internal class FakeKeystore : Provider("AndroidKeyStore", "1", "in memory") {
    private val content: MutableMap<String, Pair<PrivateKey, Certificate>> = ConcurrentHashMap()

    /** The specifications of the keys that were made, in order. */
    val made = CopyOnWriteArrayList<KeyGenParameterSpec>()

    /** The names of the keys that it holds. */
    val aliases: Set<String> get() = content.keys

    /** Runs before each of [CALLS], which it gets; it may throw, or not return. */
    @Volatile
    var before: (call: String) -> Unit = {}

    /** Holds the key of [identity] as [alias] from the start. */
    fun add(alias: String, identity: DeviceIdentity) {
        content[alias] = Held(identity.privateKey) to identity.certificate
    }

    init {
        putService(service("KeyStore", "AndroidKeyStore") { Store() })
        putService(service("KeyPairGenerator", "EC") { Generator() })
        putService(service("Signature", "SHA256withECDSA") { Signer() })
    }

    /** Loses all keys, as a device does whose lock screen is removed. */
    fun forget(): Unit = content.clear()

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

            override fun supportsParameter(parameter: Any?) = parameter is Held
        }

    private inner class Generator : KeyPairGeneratorSpi() {
        private lateinit var specification: KeyGenParameterSpec

        override fun initialize(parameters: AlgorithmParameterSpec, random: SecureRandom?) {
            specification = parameters as KeyGenParameterSpec
        }

        override fun initialize(size: Int, random: SecureRandom?) = error("without a specification")

        override fun generateKeyPair(): KeyPair {
            before("generateKeyPair")
            val next = if (made.size % 2 == 0) TestIdentity.device else TestIdentity.other
            add(specification.keystoreAlias, next)
            made += specification
            return KeyPair(next.certificate.publicKey, next.privateKey)
        }
    }

    /** A key whose bytes nobody sees. */
    private class Held(val key: PrivateKey) : PrivateKey {
        override fun getAlgorithm(): String = key.algorithm

        override fun getFormat(): String? = null

        override fun getEncoded(): ByteArray? = null
    }

    private inner class Signer : SignatureSpi() {
        private val signature = Signature.getInstance("SHA256withECDSA", "SunEC")

        override fun engineInitSign(key: PrivateKey) {
            before("sign")
            signature.initSign((key as Held).key)
        }

        override fun engineUpdate(byte: Byte) = signature.update(byte)

        override fun engineUpdate(bytes: ByteArray, offset: Int, length: Int) = signature.update(bytes, offset, length)

        override fun engineSign(): ByteArray = signature.sign()

        override fun engineInitVerify(key: PublicKey) = error("not asked for")

        override fun engineVerify(signature: ByteArray) = error("not asked for")

        @Deprecated("by Java")
        override fun engineSetParameter(name: String, value: Any) = error("not asked for")

        @Deprecated("by Java")
        override fun engineGetParameter(name: String) = error("not asked for")
    }

    private inner class Store : KeyStoreSpi() {
        override fun engineLoad(stream: InputStream?, password: CharArray?) = before("load")

        override fun engineGetKey(alias: String, password: CharArray?): Key? {
            before("getKey")
            return content[alias]?.first
        }

        override fun engineGetCertificate(alias: String): Certificate? {
            before("getCertificate")
            return content[alias]?.second
        }

        override fun engineContainsAlias(alias: String): Boolean = alias in content

        override fun engineIsKeyEntry(alias: String): Boolean {
            before("isKeyEntry")
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
    companion object {
        /** The product's calls, in their order; it generates a key if there is none. */
        val CALLS = listOf("load", "isKeyEntry", "generateKeyPair", "getKey", "getCertificate", "sign")
    }
}
