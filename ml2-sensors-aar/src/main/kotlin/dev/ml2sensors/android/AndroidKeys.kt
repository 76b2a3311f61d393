package dev.ml2sensors.android

import android.content.Context
import android.security.keystore.KeyGenParameterSpec
import android.security.keystore.KeyProperties
import dev.ml2sensors.pairing.DeviceKeys
import dev.ml2sensors.transport.DeviceIdentity
import java.io.File
import java.io.IOException
import java.security.GeneralSecurityException
import java.security.KeyPairGenerator
import java.security.KeyStore
import java.security.PrivateKey
import java.security.ProviderException
import java.security.UnrecoverableKeyException
import java.security.cert.X509Certificate
import java.security.spec.ECGenParameterSpec
import java.util.Date
import javax.security.auth.x500.X500Principal

/** The keys of this app on this headset: the private one in Android's Keystore, which does not let it out. */
internal object AndroidKeys {
    private const val PROVIDER = "AndroidKeyStore"
    private const val ALIAS = "dev.ml2sensors.device"

    /** 2000-01-01 and the last second of 9999, RFC 5280, 4.1.2.5: the headset's date may be wrong. */
    private val NOT_BEFORE = Date(946_684_800_000)
    private val NOT_AFTER = Date(253_402_300_799_000)

    /**
     * The private key is looked for, and made when there is none, when it is first needed. One that the Keystore lists and
     * cannot read is an IOException: a new one would be unknown to all receivers.
     */
    fun of(context: Context): DeviceKeys = of(context) { reason ->
        throw IOException("$reason; pair this headset again by `ml2-receiver pair`, which makes a new key")
    }

    /** As [of], but replaces an unreadable key; [replaced] receives the reason. */
    fun forPairing(context: Context, replaced: (reason: String) -> Unit): DeviceKeys = of(context, replaced)

    private fun of(context: Context, unreadable: (reason: String) -> Unit) =
        DeviceKeys(lazy { identity(unreadable) }, File(context.filesDir, "ml2-sensors-receivers.json"))

    /** @throws IOException when the Keystore fails. */
    @Synchronized
    private fun identity(unreadable: (reason: String) -> Unit): DeviceIdentity = try {
        val store = KeyStore.getInstance(PROVIDER).apply { load(null) }
        if (!store.isKeyEntry(ALIAS)) make()
        try {
            read(store)
        } catch (e: UnrecoverableKeyException) {
            unreadable("Android's Keystore cannot read the key of this app: ${e.message}")
            make()
            read(store)
        }
    } catch (e: GeneralSecurityException) {
        throw failed(e)
    } catch (e: ProviderException) {
        throw failed(e)
    }

    /** @throws UnrecoverableKeyException if the key or its certificate is there in name only. */
    private fun read(store: KeyStore): DeviceIdentity {
        val key = store.getKey(ALIAS, null) as? PrivateKey ?: throw UnrecoverableKeyException("no private key")
        val certificate = store.getCertificate(ALIAS) as? X509Certificate
        return DeviceIdentity(key, certificate ?: throw UnrecoverableKeyException("no certificate"))
    }

    private fun failed(cause: Exception) = IOException("Android's Keystore returned no key: ${cause.message}", cause)

    /** TLS signs digests that it has made itself, pairing has SHA-256 made. */
    private fun make() {
        val specification = KeyGenParameterSpec.Builder(ALIAS, KeyProperties.PURPOSE_SIGN)
            .setAlgorithmParameterSpec(ECGenParameterSpec("secp256r1"))
            .setDigests(KeyProperties.DIGEST_NONE, KeyProperties.DIGEST_SHA256)
            .setCertificateSubject(X500Principal("CN=ML2 Sensors"))
            .setCertificateNotBefore(NOT_BEFORE)
            .setCertificateNotAfter(NOT_AFTER)
            .build()
        KeyPairGenerator.getInstance(KeyProperties.KEY_ALGORITHM_EC, PROVIDER).run {
            initialize(specification)
            generateKeyPair()
        }
    }
}
