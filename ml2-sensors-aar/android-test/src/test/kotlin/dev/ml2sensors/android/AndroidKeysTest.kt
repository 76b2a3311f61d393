package dev.ml2sensors.android

import android.security.keystore.KeyPermanentlyInvalidatedException
import android.security.keystore.KeyProperties
import dev.ml2sensors.pairing.PairingException
import dev.ml2sensors.pairing.PairingPeer
import dev.ml2sensors.stream.StreamerState
import kotlinx.coroutines.Dispatchers
import kotlinx.coroutines.flow.first
import kotlinx.coroutines.launch
import kotlinx.coroutines.runBlocking
import org.junit.Test
import org.junit.runner.RunWith
import org.robolectric.RobolectricTestRunner
import org.robolectric.RuntimeEnvironment
import org.robolectric.annotation.Config
import java.io.IOException
import java.security.KeyStoreException
import java.security.ProviderException
import java.security.UnrecoverableKeyException
import java.security.spec.ECGenParameterSpec
import java.time.Instant
import java.util.concurrent.CopyOnWriteArrayList
import java.util.concurrent.CountDownLatch
import java.util.concurrent.atomic.AtomicInteger
import kotlin.test.assertEquals
import kotlin.test.assertFailsWith
import kotlin.test.assertIs
import kotlin.test.assertNotEquals
import kotlin.test.assertTrue
import kotlin.time.Duration.Companion.milliseconds

@RunWith(RobolectricTestRunner::class)
@Config(sdk = [29], manifest = Config.NONE)
class AndroidKeysTest {
    private val app = RuntimeEnvironment.getApplication()
    private val keystore = FakeKeystore()

    @Test
    fun theKeyIsMadeOnceInTheKeystoreAsTheProtocolAsksFor() = keystore.use {
        val first = AndroidKeys.of(app).identity.fingerprint
        assertEquals(first, AndroidKeys.of(app).identity.fingerprint)
        val made = keystore.made.single()
        assertEquals("secp256r1", assertIs<ECGenParameterSpec>(made.algorithmParameterSpec).name)
        assertEquals(KeyProperties.PURPOSE_SIGN, made.purposes)
        assertEquals(setOf(KeyProperties.DIGEST_NONE, KeyProperties.DIGEST_SHA256), made.digests.toSet())
        assertEquals(Instant.parse("2000-01-01T00:00:00Z"), made.certificateNotBefore.toInstant())
        assertEquals(Instant.parse("9999-12-31T23:59:59Z"), made.certificateNotAfter.toInstant())
    }

    @Test
    fun aHeadsetThatIsNotPairedSaysWhatToDo() = keystore.use {
        Ml2Sensors.open(app).use { headset ->
            val streamer = Ml2Sensors.connect(app, headset).apply { start() }
            val state = runBlocking { streamer.state.first { it != StreamerState.Connecting(reason = null) } }
            assertTrue("ml2-receiver pair" in assertIs<StreamerState.Connecting>(state).reason.orEmpty())
            runBlocking { streamer.stop() }
        }
    }

    @Test
    fun aKeystoreThatFailsIsAnInputOutputFailure() {
        assertReturnsNoKey()
        keystore.use {
            for (failure in listOf(KeyStoreException("no"), ProviderException("no"), NullPointerException(null))) {
                for (failing in listOf("load", "isKeyEntry", "generateKeyPair")) {
                    keystore.before = { call -> if (call == failing) throw failure }
                    assertReturnsNoKey()
                }
            }
            assertEquals(emptyList(), keystore.made)
        }
    }

    private fun assertReturnsNoKey() {
        for (ask in listOf({ AndroidKeys.of(app).identity }, { runBlocking { Ml2Sensors.pair(app, NOBODY) } })) {
            val failure = assertFailsWith<IOException> { ask() }
            assertTrue("Android's Keystore returned no key" in failure.message.orEmpty(), "$failure")
        }
    }

    @Test
    fun aKeystoreThatDoesNotAnswerFailsEveryCallerAndMakesOneKeyWhenItDoes() {
        for (held in FakeKeystore.CALLS) {
            val keystore = FakeKeystore()
            val answer = CountDownLatch(1)
            keystore.before = { call -> if (call == held) answer.await() }
            keystore.use {
                repeat(2) {
                    val failure = assertFailsWith<IOException> { AndroidKeys.of(app, limit = 50.milliseconds).identity }
                    assertTrue("Keystore: no answer within 50ms" in failure.message.orEmpty(), "$held: $failure")
                }
                answer.countDown()
                val first = AndroidKeys.of(app).identity.fingerprint
                assertEquals(first, AndroidKeys.of(app).identity.fingerprint)
                assertEquals(1, keystore.made.size, held)
            }
        }
    }

    @Test
    fun aKeyThatCannotBeUsedIsReplacedByPairingAloneWhichSaysSo() = keystore.use {
        val unusable = listOf(
            "getKey" to UnrecoverableKeyException("Failed to obtain information about key"),
            "getKey" to NullPointerException(null),
            "getCertificate" to ProviderException("no"),
            "sign" to KeyPermanentlyInvalidatedException("no"),
            "sign" to ProviderException("no"),
        )
        for ((failing, failure) in unusable) {
            val first = AndroidKeys.of(app).identity.fingerprint
            val made = keystore.made.size
            keystore.before = { call -> if (call == failing && keystore.made.size == made) throw failure }
            val refusal = assertFailsWith<IOException> { AndroidKeys.of(app).identity }
            assertTrue("cannot read the key" in refusal.message.orEmpty(), "$failure: $refusal")
            assertTrue("ml2-receiver pair" in refusal.message.orEmpty(), "$failure: $refusal")
            assertEquals(made, keystore.made.size, "a new key would be unknown to all receivers")
            val reasons = pairTwiceAtATime()
            assertTrue("cannot read the key" in reasons.single(), "$failure: $reasons")
            val kept = List(3) { AndroidKeys.of(app).identity.fingerprint }.distinct().single()
            assertNotEquals(first, kept)
            assertEquals(made + 1, keystore.made.size, "$failure: one key is made")
            assertEquals(1, keystore.aliases.size, "and kept")
        }
    }

    @Test
    fun aKeyThatStopsSigningFailsThePairingWithAReason() = keystore.use {
        PairingPeer.accepting(1).use { receiver ->
            val signatures = AtomicInteger()
            keystore.before = { if (it == "sign" && signatures.incrementAndGet() > 1) throw ProviderException("no") }
            val failure = assertFailsWith<PairingException> { runBlocking { Ml2Sensors.pair(app, receiver.uri) } }
            assertTrue("signing with the device's key failed: no" in failure.message.orEmpty(), "$failure")
        }
        assertEquals(1, keystore.made.size)
    }

    /** Returns the reasons why keys were replaced. Nobody listens, which is all that the pairings fail by. */
    private fun pairTwiceAtATime(): List<String> {
        val reasons = CopyOnWriteArrayList<String>()
        runBlocking(Dispatchers.IO) {
            repeat(2) {
                launch {
                    val refusal = assertFailsWith<IOException> { Ml2Sensors.pair(app, NOBODY) { reasons += it } }
                    assertTrue("Keystore" !in refusal.message.orEmpty(), "$refusal")
                }
            }
        }
        return reasons
    }

    @Test
    fun whatIsNoPairingUriIsRefusedBeforeAnythingIsMade() = keystore.use {
        assertFailsWith<IllegalArgumentException> { runBlocking { Ml2Sensors.pair(app, "ml2s://desk:1") } }
        assertEquals(emptyList(), keystore.made)
    }

    private companion object {
        val NOBODY = "ml2s://127.0.0.1:1?fp=${"0".repeat(64)}&token=${"0".repeat(32)}"
    }
}
