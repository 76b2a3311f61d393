package dev.ml2sensors.android

import android.content.Context
import android.security.keystore.KeyGenParameterSpec
import android.security.keystore.KeyProperties
import dev.ml2sensors.pairing.DeviceKeys
import dev.ml2sensors.transport.DeviceIdentity
import java.io.File
import java.io.IOException
import java.security.KeyPairGenerator
import java.security.KeyStore
import java.security.PrivateKey
import java.security.UnrecoverableKeyException
import java.security.cert.X509Certificate
import java.security.spec.ECGenParameterSpec
import java.util.Date
import java.util.concurrent.ExecutionException
import java.util.concurrent.FutureTask
import java.util.concurrent.LinkedBlockingQueue
import java.util.concurrent.ThreadPoolExecutor
import java.util.concurrent.TimeUnit
import java.util.concurrent.TimeoutException
import javax.security.auth.x500.X500Principal
import kotlin.time.Duration
import kotlin.time.Duration.Companion.seconds

/** The keys of this app on this headset: the private one in Android's Keystore, which does not let it out. */
internal object AndroidKeys {
    private const val PROVIDER = "AndroidKeyStore"
    private const val ALIAS = "dev.ml2sensors.device"

    /** 2000-01-01 and the last second of 9999, RFC 5280, 4.1.2.5: the headset's date may be wrong. */
    private val NOT_BEFORE = Date(946_684_800_000)
    private val NOT_AFTER = Date(253_402_300_799_000)

    /** Many times what a Keystore takes to make a key. */
    private val LIMIT = 30.seconds
    private const val IDLE_SECONDS = 5L

    /** Does one thing at a time, since two keys that are made at a time would replace each other. */
    private val KEYSTORE = ThreadPoolExecutor(0, 1, IDLE_SECONDS, TimeUnit.SECONDS, LinkedBlockingQueue()) {
        Thread(it, "ml2s keystore").apply { isDaemon = true }
    }

    /**
     * The private key is looked for, and made when there is none, when it is first needed. One that the Keystore lists and
     * cannot read is an IOException: a new one would be unknown to all receivers.
     *
     * @param limit how long the Keystore may take.
     */
    fun of(context: Context, limit: Duration = LIMIT): DeviceKeys = of(context, limit) { reason ->
        throw IOException("$reason; pair this headset again by `ml2-receiver pair`, which makes a new key")
    }

    /** As [of], but replaces an unreadable key; [replaced] receives the reason. */
    fun forPairing(context: Context, replaced: (reason: String) -> Unit): DeviceKeys = of(context, LIMIT, replaced)

    private fun of(context: Context, limit: Duration, unreadable: (reason: String) -> Unit): DeviceKeys {
        // Without a lock, which would be held while the Keystore is awaited
        val identity = lazy(LazyThreadSafetyMode.PUBLICATION) { answer(limit) { identity(unreadable) } }
        return DeviceKeys(identity, File(context.filesDir, "ml2-sensors-receivers.json"))
    }

    /** @throws IOException when the Keystore fails, or has not answered within [limit]. */
    private fun <T> answer(limit: Duration, question: () -> T): T {
        val call = FutureTask(question)
        KEYSTORE.execute(call)
        return try {
            call.get(limit.inWholeMilliseconds, TimeUnit.MILLISECONDS)
        } catch (e: ExecutionException) {
            throw e.cause ?: e
        } catch (_: TimeoutException) {
            call.cancel(false)
            KEYSTORE.remove(call)
            throw IOException("Android's Keystore: no answer within $limit; if that lasts, restart the headset")
        }
    }

    private fun identity(unreadable: (reason: String) -> Unit): DeviceIdentity {
        val store = asked { KeyStore.getInstance(PROVIDER).apply { load(null) } }
        if (!asked { store.isKeyEntry(ALIAS) }) asked { make() }
        return try {
            read(store)
        } catch (e: Exception) { // Keystores throw more kinds than are documented
            unreadable("Android's Keystore cannot read the key of this app: ${e.message ?: e.javaClass.simpleName}")
            asked {
                make()
                read(store)
            }
        }
    }

    /** Returns the answer of the Keystore; whatever it throws becomes an IOException. */
    private fun <T> asked(question: () -> T): T = try {
        question()
    } catch (e: Exception) {
        throw IOException("Android's Keystore returned no key: ${e.message ?: e.javaClass.simpleName}", e)
    }

    /** Returns the key, with which it has signed once: an invalidated one is listed and read like any other. */
    private fun read(store: KeyStore): DeviceIdentity {
        val key = store.getKey(ALIAS, null) as? PrivateKey ?: throw UnrecoverableKeyException("no private key")
        val certificate = store.getCertificate(ALIAS) as? X509Certificate
        val identity = DeviceIdentity(key, certificate ?: throw UnrecoverableKeyException("no certificate"))
        identity.sign(ByteArray(0))
        return identity
    }

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
