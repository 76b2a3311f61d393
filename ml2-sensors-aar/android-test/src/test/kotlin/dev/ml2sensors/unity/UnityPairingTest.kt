package dev.ml2sensors.unity

import android.content.Context
import android.net.nsd.NsdManager
import android.util.Log
import dev.ml2sensors.android.AndroidKeys
import dev.ml2sensors.android.FakeKeystore
import dev.ml2sensors.android.FakeNsdManager
import dev.ml2sensors.pairing.PairedReceiver
import dev.ml2sensors.pairing.PairingPeer
import dev.ml2sensors.pairing.ReceiverStore
import dev.ml2sensors.session.HostFrame
import dev.ml2sensors.session.ScriptedHost
import dev.ml2sensors.transport.TestIdentity
import dev.ml2sensors.transport.TlsPeer
import dev.ml2sensors.unity.UnityProbe.Companion.pairing
import dev.ml2sensors.unity.UnityProbe.Companion.state
import dev.ml2sensors.unity.UnityProbe.Companion.streams
import dev.ml2sensors.unity.UnityProbe.Companion.text
import kotlinx.serialization.json.JsonObject
import kotlinx.serialization.json.boolean
import kotlinx.serialization.json.jsonArray
import kotlinx.serialization.json.jsonObject
import kotlinx.serialization.json.jsonPrimitive
import org.junit.Test
import org.junit.runner.RunWith
import org.robolectric.RobolectricTestRunner
import org.robolectric.RuntimeEnvironment
import org.robolectric.Shadows.shadowOf
import org.robolectric.annotation.Config
import org.robolectric.shadow.api.Shadow
import org.robolectric.shadows.ShadowLog
import java.io.File
import java.util.concurrent.CountDownLatch
import kotlin.test.assertEquals
import kotlin.test.assertFalse
import kotlin.test.assertTrue

/** Pairing and encryption as C# sees them, with a scripted receiver. */
@RunWith(RobolectricTestRunner::class)
@Config(sdk = [29], manifest = Config.NONE, shadows = [FakeNsdManager::class])
class UnityPairingTest {
    private val app = RuntimeEnvironment.getApplication()
    private val keystore = FakeKeystore()

    @Test
    fun whoIsNotPairedIsToldSoWhateverTheReceiver() = withKeys { probe ->
        TlsPeer { }.use { peer ->
            for (receiver in listOf("", "127.0.0.1:${peer.port}")) {
                probe.unity.start(receiver, """{"battery": {}}""", insecure = false)
                // Before it, a busy machine says that making the key took too long
                val reason = "this headset is not paired with any receiver; run ml2-receiver pair"
                val alone = probe.await {
                    it.receiver == receiver && "battery" in it.streams && it.text("reason") == reason
                }
                assertEquals("connecting", alone.state)
                assertFalse(alone.isInsecure)
            }
        }
    }

    @Test
    fun whatWasStartedStreamsEncryptedAsSoonAsItIsPaired() = withKeys { probe ->
        probe.unity.start("", "{}", insecure = false)
        secureHost().use { host ->
            PairingPeer.accepting(host.address.port).use { receiver ->
                probe.unity.pair(" ${receiver.uri}\n")
                probe.await { it.pairing.state == "running" }
                val paired = probe.await { it.pairing.state == "paired" }.receivers.single().jsonObject
                assertEquals("desk", paired.text("name"))
                assertEquals(TestIdentity.receiver.fingerprint.hex, paired.text("fingerprint"))
                assertEquals("${host.address}", paired.text("address"))
                receiver.awaitEnd()
            }
            val session = host.awaitHello().apply { welcome(host.received()) }
            assertEquals("scripted", probe.await { it.state == "connected" }.text("receiver"))
            probe.unity.stop()
            session.await(HostFrame.BYE)
        }
    }

    @Test
    fun aReceiverWithAnotherKeyIsRefusedUntilItIsPairedAnew() = withKeys { probe ->
        secureHost().use { host ->
            val old = TestIdentity.other.fingerprint
            val file = File(app.filesDir, "ml2-sensors-receivers.json")
            ReceiverStore(file).add(PairedReceiver("desk", old, host.address.copy(fingerprint = old)))
            probe.unity.start("${host.address}", "{}", insecure = false)
            probe.await { "is not the one this headset is paired with" in it.text("reason") }
            PairingPeer.accepting(host.address.port).use {
                probe.unity.pair(it.uri)
                it.awaitEnd()
            }
            val session = host.awaitHello().apply { welcome(host.received()) }
            probe.await { it.state == "connected" }
            probe.unity.stop()
            session.await(HostFrame.BYE)
        }
    }

    @Test
    fun aPairingThatFailsSaysWhyAndTheNextMaySucceed() = withKeys { probe ->
        val reasons = mutableListOf<String>()
        PairingPeer.refusing("wrong token").use { receiver ->
            for ((index, uri) in listOf("ml2s://desk", receiver.uri).withIndex()) {
                probe.unity.pair(uri)
                val failed = probe.await { it.pairing.state == "failed" && it.pairing.text("number") == "${index + 1}" }
                reasons += failed.pairing.text("reason")
                assertEquals(0, failed.receivers.size)
            }
        }
        assertTrue("expected ml2s://HOST:PORT" in reasons[0], reasons[0])
        assertTrue("wrong token" in reasons[1], reasons[1])
        assertFalse(PairingPeer.TOKEN in reasons[1])
        PairingPeer.accepting(1).use {
            probe.unity.pair(it.uri)
            probe.await { status -> status.pairing.state == "paired" }
        }
    }

    @Test
    fun aSecondPairingIsPassedOverWhileOneIsUnderWay() = withKeys { probe ->
        PairingPeer.accepting(1).use { receiver ->
            repeat(2) { probe.unity.pair(receiver.uri) }
            val over = probe.await { it.pairing.state != "running" && it.pairing.text("number") != "0" }
            assertEquals("paired" to "1", over.pairing.state to over.pairing.text("number"))
        }
    }

    @Test
    fun aPairingThatRunsHasFailedOnceItIsClosed() = withKeys { probe ->
        val mayEnd = CountDownLatch(1)
        PairingPeer { _, _ -> mayEnd.await() }.use { receiver ->
            probe.unity.pair(receiver.uri)
            probe.unity.close()
            // Closing goes on beside its caller after a limit
            while (probe.status().pairing.text("state") == "running") Thread.yield()
            val over = probe.status().pairing
            assertEquals("failed" to "it was closed meanwhile", over.text("state") to over.text("reason"))
            mayEnd.countDown()
        }
    }

    @Test
    fun whatEarlierRunsHavePairedIsKnownBeforeAnythingStarts() = withKeys { first ->
        PairingPeer.accepting(7755).use {
            first.unity.pair(it.uri)
            first.await { status -> status.pairing.state == "paired" }
        }
        UnityProbe().use { next ->
            next.await { it.receivers.size == 1 && it.pairing.state == "none" }
        }
    }

    @Test
    fun aFileThatCannotBeReadIsTold() = withKeys { _ ->
        File(app.filesDir, "ml2-sensors-receivers.json").writeText("{")
        UnityProbe().use { probe -> probe.await { "is damaged; run ml2-receiver pair" in it.text("reason") } }
    }

    @Test
    fun insecureIsLoudAndShowsNoEyes() = withKeys { probe ->
        ScriptedHost().use { host ->
            probe.unity.start("${host.address}", "{}", insecure = true)
            val session = host.awaitHello().apply { welcome(host.received()) }
            val eyes = session.configure(1, """{"eye_nasal_left": {}}""").getValue("eye_nasal_left").jsonObject
            assertTrue("eye images are biometric" in eyes.text("reason"), "$eyes")
            assertTrue(probe.await { it.state == "connected" }.isInsecure)
            probe.unity.stop()
            session.await(HostFrame.BYE)
        }
        val warnings = ShadowLog.getLogsForTag("ML2 Sensors").filter { it.type == Log.WARN }
        assertTrue("nothing is encrypted" in warnings.single().msg)
        assertEquals(emptyList(), keystore.made, "no key is needed")
    }

    /** On a network where nobody announces himself. */
    private fun withKeys(test: (UnityProbe) -> Unit) {
        shadowOf(app).setSystemService(Context.NSD_SERVICE, Shadow.newInstanceOf(NsdManager::class.java))
        keystore.use { UnityProbe().use(test) }
    }

    /** Takes this app and nobody else. */
    private fun secureHost() =
        ScriptedHost(server = TlsPeer.serverSocket(TlsPeer.trusting(AndroidKeys.of(app).identity)))

    private val JsonObject.receiver get() = text("receiver")
    private val JsonObject.receivers get() = pairing.getValue("receivers").jsonArray
    private val JsonObject.isInsecure get() = getValue("insecure").jsonPrimitive.boolean
}
