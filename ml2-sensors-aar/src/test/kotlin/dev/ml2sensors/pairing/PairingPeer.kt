package dev.ml2sensors.pairing

import dev.ml2sensors.session.HostFrame
import dev.ml2sensors.transport.TestIdentity
import dev.ml2sensors.transport.TlsPeer
import java.io.Closeable
import java.io.DataInputStream
import java.io.IOException
import javax.net.ssl.SSLSocket
import kotlin.test.assertEquals
import kotlin.test.assertNull

/** `ml2-receiver pair` by script: sends its challenge, waits for PAIR, and does what [answer] does. */
internal class PairingPeer(
    private val nonce: String = NONCE,
    private val answer: (SSLSocket, HostFrame) -> Unit,
) : Closeable {
    private val peer = TlsPeer(needsCertificate = false, script = ::pair)

    val uri: String get() = "ml2s://127.0.0.1:${peer.port}?fp=${TestIdentity.receiver.fingerprint}&token=$TOKEN"

    private fun pair(socket: SSLSocket) {
        socket.write(PAIR_CHALLENGE, """{"nonce": "$nonce", "name": "desk", "software": "test"}""")
        val frame = HostFrame.read("pairing", DataInputStream(socket.inputStream)) ?: return
        assertEquals(PAIR, frame.kind)
        answer(socket, frame)
    }

    /** Waits until a device has been served, and fails when the answer did. */
    fun awaitEnd() = assertNull(peer.awaitOutcome()?.takeIf { it !is IOException })

    override fun close(): Unit = peer.close()

    companion object {
        private const val PAIR_CHALLENGE = 60
        private const val PAIR = 61
        private const val PAIRED = 62
        const val TOKEN = "00112233445566778899aabbccddeeff"
        val NONCE = "fedcba9876543210".repeat(4)

        /** Pairs every device, and says that sessions are served on [port]. */
        fun accepting(port: Int) = PairingPeer { socket, _ ->
            socket.paired("""{"name": "desk", "port": $port, "later": 1}""")
            assertEquals(-1, socket.inputStream.read(), "it ends the connection")
        }

        /** Pairs none. */
        fun refusing(reason: String) = PairingPeer { socket, _ ->
            socket.write(HostFrame.ERROR, """{"code": "pairing", "message": "$reason", "fatal": true}""")
            socket.inputStream.read()
        }

        fun SSLSocket.paired(json: String) = write(PAIRED, json)

        private fun SSLSocket.write(kind: Int, json: String) =
            outputStream.write(HostFrame.bytes(kind, json.toByteArray()))
    }
}
