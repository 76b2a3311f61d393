package dev.ml2sensors.pairing

import dev.ml2sensors.pairing.PairingPeer.Companion.NONCE
import dev.ml2sensors.pairing.PairingPeer.Companion.TOKEN
import dev.ml2sensors.pairing.PairingPeer.Companion.paired
import dev.ml2sensors.session.Connection
import dev.ml2sensors.session.HostFrame
import dev.ml2sensors.session.ReceiverAddress
import dev.ml2sensors.session.ReceiverBrowser
import dev.ml2sensors.source.Headset
import dev.ml2sensors.transport.Fingerprint
import dev.ml2sensors.transport.NotPairedException
import dev.ml2sensors.transport.TestIdentity
import dev.ml2sensors.transport.TlsPeer
import dev.ml2sensors.transport.WrongReceiverException
import kotlinx.coroutines.awaitCancellation
import kotlinx.coroutines.delay
import kotlinx.coroutines.flow.flow
import kotlinx.coroutines.runBlocking
import kotlinx.coroutines.test.runTest
import kotlinx.serialization.json.jsonPrimitive
import org.junit.jupiter.api.io.TempDir
import java.io.File
import java.io.IOException
import java.security.Signature
import java.security.cert.CertificateFactory
import java.security.cert.X509Certificate
import java.util.Base64
import kotlin.concurrent.thread
import kotlin.test.Test
import kotlin.test.assertEquals
import kotlin.test.assertFailsWith
import kotlin.test.assertFalse
import kotlin.test.assertTrue
import kotlin.time.Duration.Companion.seconds

class DeviceKeysTest {
    @TempDir
    lateinit var folder: File

    private val device = Headset.Identity("device-1", "Größe")
    private val receiver = TestIdentity.receiver.fingerprint
    private val keys get() = DeviceKeys(TestIdentity.device, File(folder, "receivers.json"))

    @Test
    fun theDeviceProvesThatTheKeyIsItsOwnAndRemembersTheReceiver() {
        lateinit var pair: HostFrame
        val peer = PairingPeer { socket, frame ->
            pair = frame
            socket.paired("""{"name": "desk", "port": 7755, "later": 1}""")
            assertEquals(-1, socket.inputStream.read(), "it ends the connection")
        }
        pairing(peer) { uri -> assertEquals("desk", keys.pair(uri, device).name) }
        val body = pair.json.mapValues { it.value.jsonPrimitive.content }
        assertEquals(setOf("token", "name", "device_id", "certificate", "signature"), body.keys)
        assertEquals(listOf(TOKEN, "Größe", "device-1"), listOf("token", "name", "device_id").map(body::getValue))
        val der = Base64.getDecoder().decode(body["certificate"])
        val certificate = CertificateFactory.getInstance("X.509").generateCertificate(der.inputStream())
        assertEquals(TestIdentity.device.certificate, certificate as X509Certificate)
        val isSigned = Signature.getInstance("SHA256withECDSA").run {
            initVerify(certificate)
            update("ml2s pair 1\n$receiver\n$NONCE\n$TOKEN".toByteArray())
            verify(Base64.getDecoder().decode(body["signature"]))
        }
        assertTrue(isSigned)
        val known = PairedReceiver("desk", receiver, ReceiverAddress("127.0.0.1", 7755, receiver))
        assertEquals(listOf(known), keys.receivers)
    }

    @Test
    fun aRefusalIsToldInTheReceiversWordsAndNothingIsRemembered() {
        pairing(PairingPeer.refusing("wrong token")) { uri ->
            val failure = assertFailsWith<PairingException> { keys.pair(uri, device) }
            assertTrue("wrong token" in failure.message.orEmpty(), "$failure")
            assertFalse(TOKEN in failure.message.orEmpty(), "$failure")
        }
        assertEquals(emptyList(), keys.receivers)
    }

    @Test
    fun flawedAnswersAreRefused() {
        val flawed = listOf(
            """{"name": "desk", "port": 0}""",
            """{"name": "desk", "port": 70000}""",
            """{"name": "desk"}""",
            """{"name": 7, "port": 7755}""",
            "[]",
        )
        for (answer in flawed) {
            val peer = PairingPeer { socket, _ ->
                socket.paired(answer)
                socket.inputStream.read()
            }
            pairing(peer) { uri -> assertFailsWith<PairingException>(answer) { keys.pair(uri, device) } }
        }
        pairing(PairingPeer(nonce = "00") { socket, _ -> socket.inputStream.read() }) { uri ->
            assertFailsWith<PairingException> { keys.pair(uri, device) }
        }
    }

    @Test
    fun anotherMachineLearnsNeitherTokenNorCertificate() {
        var first = 0
        TlsPeer(needsCertificate = false) { first = it.inputStream.read() }.use { peer ->
            val uri = uri(peer.port, TestIdentity.other.fingerprint)
            assertFailsWith<WrongReceiverException> { runBlocking { keys.pair(uri, device) } }
            assertTrue(peer.awaitOutcome() is IOException && first == 0)
        }
    }

    @Test
    fun aReceiverThatIsGoneIsToldWithWhatToDo() {
        val port = TlsPeer { }.use { it.port }
        val failure = assertFailsWith<PairingException> { runBlocking { keys.pair(uri(port), device) } }
        assertTrue("127.0.0.1:$port" in "$failure" && "`ml2-receiver pair`" in "$failure", "$failure")
    }

    @Test
    fun aReceiverPairedAnewTakesItsOldPlace() {
        val store = ReceiverStore(File(folder, "receivers.json"))
        val other = TestIdentity.other.fingerprint
        store.add(PairedReceiver("desk", receiver, ReceiverAddress("a", 1, receiver)))
        store.add(PairedReceiver("robot", other, ReceiverAddress("b", 2, other)))
        store.add(PairedReceiver("desk", receiver, ReceiverAddress("c", 3, receiver)))
        assertEquals(listOf("robot" to "b", "desk" to "c"), keys.receivers.map { it.name to it.address.host })
        assertEquals(listOf("receivers.json"), folder.list()?.toList(), "nothing is left behind")
    }

    @Test
    fun aDamagedFileIsNamedAndTheNextPairingReplacesIt() {
        for (text in listOf(
            "",
            "{",
            """{"receivers": [{"name": "x", "fingerprint": "0", "host": "h", "port": 1}]}""",
        )) {
            val file = File(folder, "receivers.json").apply { writeText(text) }
            val failure = assertFailsWith<IOException> { keys.receivers }
            assertTrue("$file is damaged" in failure.message.orEmpty(), "$failure")
            paired()
            assertEquals(listOf("desk"), keys.receivers.map { it.name })
        }
    }

    @Test
    fun receiversThatArePairedAtOnceAreAllRemembered() {
        val digits = (0..9).toList()
        val pairings = digits.map { digit ->
            thread {
                val fingerprint = Fingerprint("$digit".repeat(64))
                ReceiverStore(File(folder, "receivers.json"))
                    .add(PairedReceiver("desk $digit", fingerprint, ReceiverAddress("h", 1, fingerprint)))
            }
        }
        pairings.forEach(Thread::join)
        assertEquals(digits.map { "desk $it" }, keys.receivers.map { it.name }.sorted())
    }

    @Test
    fun aReceiverThatIsPairedLaterIsFoundByWhoAskedBefore() = runTest {
        val wanted = keys.receiver(browser(emptyMap()))
        val failure = assertFailsWith<NotPairedException> { wanted.locate() }
        assertEquals("this headset is not paired with any receiver; run ml2-receiver pair", failure.message)
        paired()
        assertEquals(7755, wanted.locate().port)
    }

    @Test
    fun whoIsNotPairedConnectsToNoAddressEither() {
        TlsPeer { }.use { peer ->
            val address = ReceiverAddress("127.0.0.1", peer.port)
            assertFailsWith<NotPairedException> { Connection.open(address, keys.security(), rosNowNanos = { 0 }) }
        }
    }

    @Test
    fun aKeyStoreThatFailsOnceIsAskedAgain() {
        paired()
        var asked = 0
        val identity = lazy { if (asked++ == 0) throw IOException("locked") else TestIdentity.device }
        val keys = DeviceKeys(identity, File(folder, "receivers.json"))
        TlsPeer { it.inputStream.read() }.use { peer ->
            val (address, security) = ReceiverAddress("127.0.0.1", peer.port) to keys.security()
            assertFailsWith<IOException> { Connection.open(address, security, rosNowNanos = { 0 }) }
            Connection.open(address, security, rosNowNanos = { 0 }).close()
        }
    }

    @Test
    fun anAnnouncedReceiverIsFoundByItsFingerprintUnderAnyNameAndAddress() = runTest {
        paired()
        val there = ReceiverAddress("10.0.0.9", 9, receiver)
        val others = mapOf("desk" to ReceiverAddress("10.0.0.8", 8, TestIdentity.other.fingerprint))
        assertEquals(there, keys.receiver(browser(others + ("renamed" to there))).locate())
    }

    @Test
    fun withoutAnAnnouncementItIsWhereItWasPaired() = runTest {
        paired()
        val known = ReceiverAddress("192.168.1.5", 7755, receiver)
        assertEquals(known, keys.receiver(browser(mapOf("desk" to ReceiverAddress("10.0.0.8", 8)))).locate())
        assertEquals(known, keys.receiver({ flow { throw IOException("no network") } }).locate())
        assertTrue(testScheduler.currentTime <= 500, "a reconnection is not delayed by a second")
    }

    @Test
    fun aReceiverAtANewAddressIsFoundOverSlowMulticast() = runTest {
        paired()
        val moved = ReceiverAddress("192.168.1.9", 7755, receiver)
        val slow = ReceiverBrowser {
            flow {
                delay(2.seconds)
                emit(mapOf("desk" to moved))
                awaitCancellation()
            }
        }
        val wanted = keys.receiver(slow)
        val located = List(4) { wanted.locate() }
        assertEquals(listOf("192.168.1.5", "192.168.1.5", "192.168.1.5", "192.168.1.9"), located.map { it.host })
    }

    private fun paired() = ReceiverStore(File(folder, "receivers.json"))
        .add(PairedReceiver("desk", receiver, ReceiverAddress("192.168.1.5", 7755, receiver)))

    private fun browser(found: Map<String, ReceiverAddress>) = ReceiverBrowser {
        flow {
            emit(found)
            awaitCancellation()
        }
    }

    private fun pairing(peer: PairingPeer, test: suspend (PairingUri) -> Unit) = peer.use {
        runBlocking { test(PairingUri.parse(it.uri)) }
        it.awaitEnd()
    }

    private fun uri(port: Int, fingerprint: Fingerprint = receiver) =
        PairingUri.parse("ml2s://127.0.0.1:$port?fp=$fingerprint&token=$TOKEN")
}
