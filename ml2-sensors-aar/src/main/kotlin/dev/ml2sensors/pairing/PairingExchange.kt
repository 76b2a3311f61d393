package dev.ml2sensors.pairing

import dev.ml2sensors.session.Connection
import dev.ml2sensors.session.blockingIo
import dev.ml2sensors.session.handshake
import dev.ml2sensors.source.Headset
import dev.ml2sensors.transport.DeviceIdentity
import dev.ml2sensors.transport.TlsClient
import dev.ml2sensors.transport.TransportException
import dev.ml2sensors.transport.TransportSecurity
import dev.ml2sensors.wire.ControlJson
import dev.ml2sensors.wire.FrameKind
import dev.ml2sensors.wire.PairBody
import dev.ml2sensors.wire.PairChallenge
import dev.ml2sensors.wire.Paired
import kotlinx.coroutines.currentCoroutineContext
import kotlinx.coroutines.ensureActive
import java.io.EOFException
import java.io.IOException
import kotlin.io.encoding.Base64
import kotlin.time.Duration.Companion.seconds

/** The device's side of PROTOCOL.md, Pairing. */
internal class PairingExchange(private val identity: DeviceIdentity, private val device: Headset.Identity) {
    /** @throws IOException as [DeviceKeys.pair] does. */
    suspend fun run(uri: PairingUri): PairedReceiver {
        try {
            val paired = handshake("the end of the pairing", LIMIT) { blockingIo { exchange(uri) } }
            val address = uri.receiver.copy(port = paired.port)
            return PairedReceiver(paired.name, uri.fingerprint, address)
        } catch (e: TransportException) {
            throw e
        } catch (e: IOException) {
            currentCoroutineContext().ensureActive()
            val hint = "is `ml2-receiver pair` still open there, and shows this code?"
            throw PairingException("no pairing with the receiver at ${uri.receiver}: ${e.message}; $hint", e)
        }
    }

    private fun exchange(uri: PairingUri): Paired {
        val security = TransportSecurity.Paired { TlsClient(identity = null, setOf(uri.fingerprint)) }
        return Connection.open(uri.receiver, security, rosNowNanos = { 0 }).use { connection ->
            val challenge = connection.await<PairChallenge>(FrameKind.PAIR_CHALLENGE)
            connection.writer.write(FrameKind.PAIR, ControlJson.encode(answer(challenge, uri)))
            connection.await<Paired>(FrameKind.PAIRED).also { connection.shutdownOutput() }
        }
    }

    private fun answer(challenge: PairChallenge, uri: PairingUri): PairBody {
        val signed = "ml2s pair 1\n${uri.fingerprint}\n${challenge.nonce}\n${uri.token}"
        return PairBody(
            uri.token,
            device.name,
            device.deviceId,
            Base64.encode(identity.certificate.encoded),
            Base64.encode(identity.sign(signed.toByteArray(Charsets.US_ASCII))),
        )
    }

    private inline fun <reified T> Connection.await(kind: FrameKind): T =
        ControlJson.decode(
            (read(setOf(kind)) ?: throw EOFException("the receiver closed the connection before $kind")).body,
        )

    private companion object {
        /** The time that a user waits at most. */
        val LIMIT = 10.seconds
    }
}

/** Pairing failed: the code is wrong, used or expired, or `ml2-receiver pair` no longer runs. */
public class PairingException internal constructor(message: String, cause: Throwable? = null) :
    IOException(message, cause)
