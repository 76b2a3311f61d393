package dev.ml2sensors.session

import dev.ml2sensors.transport.DeviceIdentity
import dev.ml2sensors.transport.NotPairedException
import dev.ml2sensors.transport.TestIdentity
import dev.ml2sensors.transport.TlsClient
import dev.ml2sensors.transport.TlsPeer
import dev.ml2sensors.transport.TlsProvider
import dev.ml2sensors.transport.TransportSecurity
import dev.ml2sensors.transport.WrongReceiverException
import org.junit.jupiter.api.AfterEach
import org.junit.jupiter.api.Test
import org.junit.jupiter.params.ParameterizedClass
import org.junit.jupiter.params.provider.EnumSource
import kotlin.test.assertEquals
import kotlin.test.assertIs
import kotlin.test.assertNull

/** Sessions over TLS, with the engine of the JVM and Android's. */
@ParameterizedClass
@EnumSource(TlsProvider::class)
class SecureSessionTest(private val provider: TlsProvider) {
    private val fixture = SessionFixture(server = TlsPeer.serverSocket(TlsPeer.trusting(TestIdentity.device)))

    @AfterEach
    fun close() = fixture.close()

    @Test
    fun everyLaneIsEncryptedAndASessionEndsInOrder() {
        val outcome = fixture.run(security = paired(TestIdentity.device))
        val session = fixture.started("world_left", "color")
        repeat(20) { fixture.offer("world_left/image", payloadBytes = 1 shl 20) }
        fixture.offer("color/image")
        session.awaitData("color/image")
        fixture.stop.complete("enough")
        session.await(HostFrame.BYE)
        assertNull(fixture.outcome(outcome))
        session.awaitEnds()
        val ends = session.log().filter { it.kind == HostFrame.END }.map { it.body.decodeToString() }
        assertEquals(setOf("end"), ends.toSet())
    }

    @Test
    fun fillerOfALinkTestIsEncryptedToo() {
        fixture.run(security = paired(TestIdentity.device))
        val session = fixture.started("world_left")
        session.testLink(1_000_000)
        assertEquals(1_000_000, session.awaitFiller().sumOf { it.body.size })
    }

    @Test
    fun aDeviceThatIsNotPairedIsToldAndNeverConnected() {
        val outcome = fixture.run(security = paired(TestIdentity.other))
        assertIs<NotPairedException>(fixture.outcome(outcome))
        assertEquals(emptyList(), fixture.streams.calls.value)
    }

    @Test
    fun theAddressSaysWhichOfThePairedReceiversIsMeant() {
        val address = fixture.host.address.copy(fingerprint = TestIdentity.other.fingerprint)
        val outcome = fixture.run(address, paired(TestIdentity.device))
        assertIs<WrongReceiverException>(fixture.outcome(outcome))
    }

    private fun paired(identity: DeviceIdentity): TransportSecurity {
        val receivers = setOf(TestIdentity.receiver.fingerprint, TestIdentity.other.fingerprint)
        return TransportSecurity.Paired { TlsClient(identity, receivers, provider.newInstance()) }
    }
}
