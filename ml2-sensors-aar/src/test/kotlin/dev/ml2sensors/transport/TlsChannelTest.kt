package dev.ml2sensors.transport

import org.junit.jupiter.params.ParameterizedClass
import org.junit.jupiter.params.provider.EnumSource
import java.io.ByteArrayOutputStream
import java.io.IOException
import java.net.InetAddress
import java.net.InetSocketAddress
import java.nio.ByteBuffer
import java.nio.channels.SocketChannel
import java.security.MessageDigest
import java.util.concurrent.CountDownLatch
import javax.net.ssl.SSLSocket
import kotlin.concurrent.thread
import kotlin.random.Random
import kotlin.test.Test
import kotlin.test.assertContentEquals
import kotlin.test.assertEquals
import kotlin.test.assertFailsWith
import kotlin.test.assertFalse
import kotlin.test.assertIs
import kotlin.test.assertNull

/** Bytes there and back, through the engine of the JVM and through Android's. */
@ParameterizedClass
@EnumSource(TlsProvider::class)
class TlsChannelTest(private val provider: TlsProvider) {
    private val client =
        TlsClient(TestIdentity.device, setOf(TestIdentity.receiver.fingerprint), provider.newInstance())

    @Test
    fun gatheringWritesOfAnySizeArriveWholeAndInOrder() {
        val random = Random(1)
        val sizes = listOf(
            0 to 0,
            1 to 0,
            0 to 1,
            160 to 1016 * 1016,
            16_383 to 2,
            16_384 to 16_384,
            70_000 to 5_000_000,
        )
        val frames = sizes.map { (head, tail) -> direct(random.nextBytes(head)) to direct(random.nextBytes(tail)) }
        val expected = MessageDigest.getInstance("SHA-256")
        for ((head, tail) in frames) {
            expected.update(head.duplicate())
            expected.update(tail.duplicate())
        }
        var found = ByteArray(0)
        TlsPeer { found = digest(it) }.use { peer ->
            open(peer).use { channel ->
                for ((head, tail) in frames) {
                    val size = head.remaining() + tail.remaining()
                    assertEquals(size.toLong(), channel.write(arrayOf(head, tail)))
                    assertFalse(head.hasRemaining() || tail.hasRemaining())
                }
                channel.shutdownOutput()
                assertNull(peer.awaitOutcome())
            }
        }
        assertContentEquals(expected.digest(), found)
    }

    @Test
    fun recordsOfAByteAndOfTheLargestSizeAreRead() {
        val bytes = Random(2).nextBytes(200_000)
        TlsPeer { socket ->
            for (index in 0 until 1000) socket.outputStream.write(bytes, index, 1)
            socket.outputStream.write(bytes, 1000, bytes.size - 1000)
        }.use { peer -> open(peer).use { assertContentEquals(bytes, readAll(it, Random(3))) } }
    }

    @Test
    fun aWireThatPassesByteByByteIsReadAndWritten() {
        val bytes = Random(4).nextBytes(3_000)
        TlsPeer { socket ->
            val echo = socket.inputStream.readNBytes(bytes.size)
            socket.outputStream.write(echo)
        }.relayed(pieceBytes = 1) { channel, _ ->
            channel.write(direct(bytes))
            assertContentEquals(bytes, readAll(channel, Random(5)))
        }
    }

    @Test
    fun bothDirectionsAtOnceAndKeysThatChangeMeanwhile() {
        val bytes = Random(6).nextBytes(PARTS * PART_BYTES)
        var sent: Throwable? = null
        TlsPeer { socket ->
            socket.startHandshake()
            val writing = thread {
                sent = runCatching {
                    for (part in 0 until PARTS) {
                        if (part > 0) socket.startHandshake() // In TLS 1.3 an update of the keys, of both sides
                        socket.outputStream.write(bytes, part * PART_BYTES, PART_BYTES)
                    }
                }.exceptionOrNull()
            }
            assertContentEquals(digest(bytes), digest(socket))
            writing.join()
        }.use { peer ->
            open(peer).use { channel ->
                val writing = thread {
                    for (part in 0 until PARTS) channel.write(direct(bytes, part * PART_BYTES, PART_BYTES))
                }
                val found = read(channel, bytes.size)
                writing.join()
                channel.shutdownOutput()
                assertNull(peer.awaitOutcome())
                assertNull(sent)
                assertContentEquals(digest(bytes), digest(found))
            }
        }
    }

    @Test
    fun keysThatChangeWhileNothingIsWrittenAreFollowed() {
        TlsPeer { socket ->
            for (number in 1..3) {
                socket.startHandshake()
                socket.outputStream.write(number)
            }
            assertEquals(4, socket.inputStream.read())
        }.use { peer ->
            open(peer).use { channel ->
                assertContentEquals(byteArrayOf(1, 2, 3), read(channel, 3))
                channel.write(direct(byteArrayOf(4)))
                assertNull(peer.awaitOutcome())
            }
        }
    }

    @Test
    fun afterItsLastWordItWaitsForThePeersEnd() {
        TlsPeer { socket ->
            assertContentEquals(byteArrayOf(1, 2), socket.inputStream.readAllBytes())
            socket.outputStream.write(byteArrayOf(3, 4))
        }.use { peer ->
            open(peer).use { channel ->
                channel.write(direct(byteArrayOf(1, 2)))
                channel.shutdownOutput()
                channel.shutdownOutput()
                val heard = readAll(channel, Random(8))
                assertNull(peer.awaitOutcome(), "it was not cut off")
                if (provider == TlsProvider.JVM) assertContentEquals(byteArrayOf(3, 4), heard)
            }
        }
    }

    @Test
    fun anEndWithoutALastWordIsAnEnd() = afterTheFirstByte { channel, _ ->
        channel.shutdownInput()
        assertEquals(-1, channel.read(ByteBuffer.allocate(1)))
    }

    @Test
    fun bytesThatWereChangedOnTheWayAreFound() = afterTheFirstByte { channel, relay ->
        relay.inject(byteArrayOf(23, 3, 3, 0, 32) + ByteArray(32))
        assertFailsWith<TlsException> { read(channel, 1) }
    }

    @Test
    fun closingEndsWhatWaitsAndGivesBuffersBackOnce() {
        TlsPeer { it.inputStream.read() }.use { peer ->
            val channel = open(peer)
            val isReading = CountDownLatch(1)
            var failure: Throwable? = null
            val reading = thread {
                isReading.countDown()
                failure = runCatching { channel.read(ByteBuffer.allocate(1)) }.exceptionOrNull()
            }
            isReading.await()
            channel.close()
            channel.close()
            reading.join()
            assertIs<IOException>(failure)
            assertFailsWith<IOException> { channel.write(direct(byteArrayOf(1))) }
            val taken = List(64) { DirectBufferPool.acquire() }
            assertEquals(taken.size, taken.map { System.identityHashCode(it) }.toSet().size, "a buffer was lent twice")
            taken.forEach(DirectBufferPool::release)
        }
    }

    /** Runs [test] with a channel that has read all that its peer sends; the peer stays connected meanwhile. */
    private fun afterTheFirstByte(test: (TransportChannel, Relay) -> Unit) {
        val isOver = CountDownLatch(1)
        TlsPeer { socket ->
            socket.outputStream.write(1)
            isOver.await()
        }.relayed(pieceBytes = 100_000) { channel, relay ->
            assertContentEquals(byteArrayOf(1), read(channel, 1))
            test(channel, relay)
            isOver.countDown()
        }
    }

    private fun TlsPeer.relayed(pieceBytes: Int, test: (TransportChannel, Relay) -> Unit) = use { peer ->
        Relay(peer.port, pieceBytes).use { relay -> open(relay.port).use { channel -> test(channel, relay) } }
    }

    private fun open(peer: TlsPeer) = open(peer.port)

    private fun open(port: Int): TransportChannel =
        client.open(SocketChannel.open(InetSocketAddress(InetAddress.getLoopbackAddress(), port)), "here:$port")

    private fun digest(bytes: ByteArray) = MessageDigest.getInstance("SHA-256").digest(bytes)

    private fun digest(socket: SSLSocket): ByteArray {
        val digest = MessageDigest.getInstance("SHA-256")
        val piece = ByteArray(1 shl 16)
        while (true) {
            val count = socket.inputStream.read(piece)
            if (count < 0) return digest.digest()
            digest.update(piece, 0, count)
        }
    }

    private fun direct(bytes: ByteArray, offset: Int = 0, count: Int = bytes.size): ByteBuffer =
        ByteBuffer.allocateDirect(count + 7).position(7).put(bytes, offset, count).flip().position(7)

    private fun read(channel: TransportChannel, count: Int): ByteArray {
        val target = ByteBuffer.allocate(count)
        while (target.hasRemaining()) check(channel.read(target) >= 0) { "the stream has ended" }
        return target.array()
    }

    /** In reads of random sizes, until the end. */
    private fun readAll(channel: TransportChannel, random: Random): ByteArray {
        val whole = ByteArrayOutputStream()
        while (true) {
            val target = ByteBuffer.allocate(random.nextInt(1, 30_000))
            if (channel.read(target) < 0) return whole.toByteArray()
            whole.write(target.array(), 0, target.position())
        }
    }

    private companion object {
        const val PARTS = 40
        const val PART_BYTES = 100_000
    }
}
