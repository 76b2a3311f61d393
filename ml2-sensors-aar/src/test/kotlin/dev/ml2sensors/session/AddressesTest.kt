package dev.ml2sensors.session

import dev.ml2sensors.transport.TransportSecurity
import kotlinx.coroutines.flow.emptyFlow
import org.junit.jupiter.api.Test
import java.io.IOException
import java.net.InetAddress
import java.net.InetSocketAddress
import java.net.ServerSocket
import java.nio.channels.SocketChannel
import java.util.concurrent.CopyOnWriteArrayList
import kotlin.test.assertContains
import kotlin.test.assertEquals
import kotlin.test.assertFailsWith
import kotlin.test.assertIs

/** A receiver whose name has several addresses. */
class AddressesTest {
    @Test
    fun anAddressThatRefusesIsFollowedByTheNextWhateverItsFamily() {
        for ((refusing, serving) in listOf("127.0.0.2" to "127.0.0.1", "127.0.0.1" to "::1", "::1" to "127.0.0.1")) {
            ServerSocket(0, 1, address(serving)).use { server ->
                assertEquals(address(serving), open(server.localPort, refusing, serving).use { it.address })
            }
        }
    }

    @Test
    fun anAddressThatDoesNotAnswerIsFollowedByTheNext() {
        ServerSocket(0, 1, address("127.0.0.1")).use { server ->
            ServerSocket().use { full ->
                full.bind(InetSocketAddress(address("127.0.0.2"), server.localPort), 1)
                // Connections for which the backlog has no place are never answered
                val waiting = List(8) { SocketChannel.open().apply { configureBlocking(false) } }
                waiting.forEach { it.connect(full.localSocketAddress) }
                val found = open(server.localPort, "127.0.0.2", "127.0.0.1").use { it.address }
                waiting.forEach(SocketChannel::close)
                assertEquals(address("127.0.0.1"), found)
            }
        }
    }

    @Test
    fun whenNoneAnswersTheErrorNamesEach() {
        val port = ServerSocket(0, 1, address("127.0.0.1")).use { it.localPort }
        val error = assertFailsWith<IOException> { open(port, "127.0.0.1", "127.0.0.2") }
        for (host in listOf("127.0.0.1", "127.0.0.2")) assertContains(error.message.orEmpty(), "$host: ")
    }

    @Test
    fun theFamiliesTakeTurns() {
        val tried = CopyOnWriteArrayList<String>()
        val addresses = listOf("::1", "::2", "::3", "127.0.0.1", "127.0.0.2").map(::address)
        assertFailsWith<IOException> {
            firstThatAnswers(ReceiverAddress("name", 1), addresses) { address, limitMillis ->
                tried += "${address.address.hostAddress} $limitMillis"
                throw IOException("no")
            }
        }
        val expected = listOf("0:0:0:0:0:0:0:1 1000", "127.0.0.1 1000", "0:0:0:0:0:0:0:2 1000", "127.0.0.2 0")
        assertEquals(expected, tried)
    }

    @Test
    fun lanesGoWhereControlFoundTheReceiver() {
        SessionFixture().use { fixture ->
            val asked = CopyOnWriteArrayList<String>()
            fixture.run(fixture.host.address.copy(host = "desk")) { host ->
                asked += host
                listOf("127.0.0.2", "127.0.0.1").map(::address)
            }
            fixture.started("color")
            assertEquals(listOf("desk"), asked)
        }
    }

    @Test
    fun anAddressOfIpv6IsWrittenInBrackets() {
        ServerSocket(0, 1, address("::1")).use { server ->
            val receiver = assertIs<ReceiverAddress>(Receiver.parse("[::1]:${server.localPort}") { emptyFlow() })
            Connection.open(receiver, TransportSecurity.Insecure(), rosNowNanos = { 0 }).use {
                assertEquals(address("::1"), it.address)
            }
        }
    }

    private fun open(port: Int, vararg hosts: String): Connection =
        Connection.open(ReceiverAddress("name", port), TransportSecurity.Insecure(), { 0 }) { hosts.map(::address) }

    private fun address(text: String): InetAddress = InetAddress.getByName(text)
}

class ReceiverAddressTest {
    @Test
    fun addressesAreHostAndPort() {
        assertEquals("192.168.1.5:7447", ReceiverAddress("192.168.1.5", 7447).toString())
        assertEquals("[fe80::1]:7447", ReceiverAddress("fe80::1", 7447).toString())
    }

    @Test
    fun otherAddressesAreMisuse() {
        for (port in listOf(-1, 0, 65536)) assertFailsWith<IllegalArgumentException> { ReceiverAddress("host", port) }
        assertFailsWith<IllegalArgumentException> { ReceiverAddress("", 1) }
    }
}
