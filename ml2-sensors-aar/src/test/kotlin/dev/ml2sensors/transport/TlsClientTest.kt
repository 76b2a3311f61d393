package dev.ml2sensors.transport

import dev.ml2sensors.session.HostFrame
import org.junit.jupiter.params.ParameterizedClass
import org.junit.jupiter.params.provider.EnumSource
import java.io.IOException
import java.net.InetAddress
import java.net.InetSocketAddress
import java.net.ServerSocket
import java.net.Socket
import java.nio.ByteBuffer
import java.nio.channels.SocketChannel
import kotlin.concurrent.thread
import kotlin.test.Test
import kotlin.test.assertEquals
import kotlin.test.assertFailsWith
import kotlin.test.assertIs
import kotlin.test.assertNull
import kotlin.test.assertTrue

/** Whom a device lets answer, and what it says of others. */
@ParameterizedClass
@EnumSource(TlsProvider::class)
class TlsClientTest(private val provider: TlsProvider) {
    private val receiver = TestIdentity.receiver.fingerprint
    private val other = TestIdentity.other.fingerprint

    @Test
    fun aPinnedReceiverSeesTheDevicesCertificateAndNoOlderTls() {
        TlsPeer { socket ->
            assertEquals(1, socket.inputStream.read())
            assertEquals(TestIdentity.device.certificate, socket.session.peerCertificates.single())
            assertEquals("TLSv1.3", socket.session.protocol)
            socket.outputStream.write(2)
        }.use { peer ->
            open(client(receiver, other), peer.port).use { channel ->
                channel.write(ByteBuffer.wrap(byteArrayOf(1)))
                assertEquals(1, channel.read(ByteBuffer.allocate(5)))
                assertNull(peer.awaitOutcome())
            }
        }
    }

    @Test
    fun anotherMachineIsNamedAndSeesNothingOfTheDevice() {
        TlsPeer { it.startHandshake() }.use { peer ->
            val failure = assertFailsWith<WrongReceiverException> { open(client(other), peer.port) }
            assertEquals(
                "the receiver at desk:1 is not the one this headset is paired with (expected fingerprint $other, " +
                    "found $receiver); pair again",
                failure.message,
            )
            // The alert, unless the end of the connection overtakes it
            assertIs<IOException>(peer.awaitOutcome())
            assertEquals(0, peer.certificatesSeen.get())
        }
    }

    @Test
    fun anotherPairedReceiverIsNotTakenForTheOneThatIsExpectedNotEvenWhenItResumes() {
        TlsPeer {
            it.startHandshake()
            it.outputStream.write(1)
            it.inputStream.read()
        }.use { peer ->
            val client = client(receiver, other)
            repeat(2) {
                assertFailsWith<WrongReceiverException> { open(client, peer.port, expected = other) }
                open(client, peer.port, expected = receiver).use { it.read(ByteBuffer.allocate(1)) }
            }
        }
    }

    @Test
    fun laterLanesResumeTheFirst() {
        TlsPeer {
            it.outputStream.write(1)
            it.inputStream.read()
        }.use { peer ->
            val client = client(receiver)
            repeat(4) {
                open(client, peer.port).use { it.read(ByteBuffer.allocate(1)) }
                peer.awaitOutcome()
            }
            assertEquals(1, peer.certificatesSeen.get())
        }
    }

    @Test
    fun aRefusedDeviceLearnsItAtItsFirstRead() {
        TlsPeer(trusted = TestIdentity.other) { it.inputStream.read() }.use { peer ->
            open(client(receiver), peer.port).use { channel ->
                val failure = assertFailsWith<NotPairedException> { channel.read(ByteBuffer.allocate(1)) }
                assertEquals(
                    "this headset is not paired with the receiver at desk:1; run ml2-receiver pair",
                    failure.message,
                )
            }
        }
    }

    @Test
    fun olderTlsIsRefused() {
        TlsPeer(protocols = listOf("TLSv1.2")) { it.startHandshake() }.use { peer ->
            val failure = assertFailsWith<TlsException> { open(client(receiver), peer.port) }
            assertTrue("expected TLS 1.3 with the receiver at desk:1" in failure.message.orEmpty(), "$failure")
        }
    }

    @Test
    fun aServerOfSomethingElseIsRefused() {
        TlsPeer(applicationProtocols = emptyList()) { it.inputStream.read() }.use { peer ->
            val failure = assertFailsWith<TlsException> { open(client(receiver), peer.port) }
            assertTrue("ml2s/1" in failure.message.orEmpty(), "$failure")
        }
    }

    @Test
    fun aReceiverThatDoesNotEncryptIsNamed() {
        val error = """{"code": "malformed", "message": "no header", "fatal": true}""".toByteArray()
        plain({ it.getOutputStream().write(HostFrame.bytes(HostFrame.ERROR, error)) }) { port ->
            val failure = assertFailsWith<PlaintextReceiverException> { open(client(receiver), port) }
            assertTrue("--insecure" in failure.message.orEmpty())
        }
    }

    @Test
    fun oneThatClosesInTheHandshakeIsAFailureOfTheWorld() {
        plain({ it.getInputStream().readNBytes(5) }) { port ->
            assertFailsWith<IOException> { open(client(receiver), port) }
        }
    }

    @Test
    fun garbageInsteadOfAHandshakeIsRefused() {
        plain({ it.getOutputStream().write(byteArrayOf(22, 3, 3, 0, 4, 1, 2, 3, 4)) }) { port ->
            assertFailsWith<TlsException> { open(client(receiver), port) }
        }
    }

    private fun client(vararg pinned: Fingerprint) =
        TlsClient(TestIdentity.device, pinned.toSet(), provider.newInstance())

    private fun open(client: TlsClient, port: Int, expected: Fingerprint? = null): TransportChannel {
        val address = InetSocketAddress(InetAddress.getLoopbackAddress(), port)
        return client.open(SocketChannel.open(address), "desk:1", expected)
    }

    /** Runs [test] with the port of a server without TLS, that does [answer] and closes once the client has. */
    private fun plain(answer: (Socket) -> Unit, test: (Int) -> Unit) {
        ServerSocket(0, 1, InetAddress.getLoopbackAddress()).use { server ->
            thread(isDaemon = true) {
                server.accept().use {
                    answer(it)
                    it.shutdownOutput()
                    runCatching { it.getInputStream().readAllBytes() }
                }
            }
            test(server.localPort)
        }
    }
}
