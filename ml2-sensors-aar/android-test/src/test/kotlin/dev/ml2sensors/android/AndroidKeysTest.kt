package dev.ml2sensors.android

import android.security.keystore.KeyProperties
import dev.ml2sensors.stream.StreamerState
import kotlinx.coroutines.flow.first
import kotlinx.coroutines.runBlocking
import org.junit.Test
import org.junit.runner.RunWith
import org.robolectric.RobolectricTestRunner
import org.robolectric.RuntimeEnvironment
import org.robolectric.annotation.Config
import java.io.IOException
import java.security.spec.ECGenParameterSpec
import java.time.Instant
import java.util.concurrent.CountDownLatch
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
        val failure = assertFailsWith<IOException> { AndroidKeys.of(app).identity }
        assertTrue("Android's Keystore returned no key" in failure.message.orEmpty(), "$failure")
    }

    @Test
    fun aKeystoreThatDoesNotAnswerFailsEveryCallerAndMakesOneKeyWhenItDoes() = keystore.use {
        val answer = CountDownLatch(1)
        keystore.answer = answer
        repeat(2) {
            val failure = assertFailsWith<IOException> { AndroidKeys.of(app, limit = 50.milliseconds).identity }
            assertTrue("Keystore: no answer within 50ms" in failure.message.orEmpty(), "$failure")
        }
        answer.countDown()
        val first = AndroidKeys.of(app).identity.fingerprint
        assertEquals(first, AndroidKeys.of(app).identity.fingerprint)
        assertEquals(1, keystore.made.size)
    }

    @Test
    fun anUnreadableKeyIsReplacedByPairingAloneWhichSaysSo() = keystore.use {
        val first = AndroidKeys.of(app).identity.fingerprint
        keystore.isUnreadable = true
        val failure = assertFailsWith<IOException> { AndroidKeys.of(app).identity }
        assertTrue("cannot read the key" in failure.message.orEmpty(), "$failure")
        assertTrue("ml2-receiver pair" in failure.message.orEmpty(), "$failure")
        assertEquals(1, keystore.made.size, "a new key would be unknown to all receivers")
        val reasons = mutableListOf<String>()
        val uri = "ml2s://127.0.0.1:1?fp=${"0".repeat(64)}&token=${"0".repeat(32)}"
        val refusal = assertFailsWith<IOException> { runBlocking { Ml2Sensors.pair(app, uri) { reasons += it } } }
        assertTrue("Keystore" !in refusal.message.orEmpty(), "$refusal")
        assertTrue("cannot read the key" in reasons.single(), "$reasons")
        assertNotEquals(first, AndroidKeys.of(app).identity.fingerprint)
        assertEquals(2, keystore.made.size)
    }

    @Test
    fun whatIsNoPairingUriIsRefusedBeforeAnythingIsMade() = keystore.use {
        assertFailsWith<IllegalArgumentException> { runBlocking { Ml2Sensors.pair(app, "ml2s://desk:1") } }
        assertEquals(emptyList(), keystore.made)
    }
}
