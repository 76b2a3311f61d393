package dev.ml2sensors.transport

import dev.ml2sensors.capture.Simulation
import org.junit.jupiter.api.Test
import java.net.InetAddress
import java.net.InetSocketAddress
import java.net.SocketAddress
import java.net.StandardSocketOptions
import java.nio.ByteBuffer
import java.nio.channels.ServerSocketChannel
import java.nio.channels.SocketChannel
import kotlin.test.assertEquals
import kotlin.test.assertNotNull
import kotlin.test.assertTrue

/** With the library of the headset, and real connections. */
class SendQueueTest {
    init {
        Simulation.begin()
    }

    @Test
    fun whatThePeerCannotTakeIsHeldAndThenGone() = connected { local, peer ->
        val writtenBytes = fill(local)
        val queue = assertNotNull(SendQueue.of(local))
        assert(queue.bytes in 1..<writtenBytes) { "${queue.bytes} of $writtenBytes bytes" }
        val taken = ByteBuffer.allocate(writtenBytes)
        while (taken.hasRemaining()) peer.read(taken)
        while (queue.bytes > 0) Thread.onSpinWait()
    }

    @Test
    fun onlyABoundedPartOfItWasNotSent() = connected { local, _ ->
        val queue = assertNotNull(SendQueue.of(local))
        assertTrue(queue.limitUnsent(1 shl 14))
        fill(local)
        // The kernel looks at the bound before each of its buffers of 64 KiB; without it, megabytes wait
        assertTrue(queue.bytes < 3 shl 16, "${queue.bytes} bytes")
    }

    @Test
    fun eachConnectionHasItsOwn() = connected { local, _ ->
        connected { other, _ ->
            other.write(ByteBuffer.allocate(100_000))
            assertEquals(0, assertNotNull(SendQueue.of(local)).bytes)
        }
    }

    @Test
    fun connectionsOfTheSamePortsToTwoAddressesAreNotConfused() = listening("127.0.0.2", 0) { one ->
        listening("127.0.0.3", (one.localAddress as InetSocketAddress).port) { other ->
            from(InetSocketAddress("127.0.0.1", 0), one) { first ->
                from(first.localAddress, other) { second ->
                    fill(second)
                    assertEquals(0, assertNotNull(SendQueue.of(first)).bytes)
                    assertTrue(assertNotNull(SendQueue.of(second)).bytes > 0)
                }
            }
        }
    }

    /** Writes until the kernel takes no more; returns the bytes that it took. */
    private fun fill(channel: SocketChannel): Int {
        channel.configureBlocking(false)
        return generateSequence { channel.write(ByteBuffer.allocate(1 shl 16)).takeIf { it > 0 } }.sum()
    }

    private fun listening(host: String, port: Int, use: (ServerSocketChannel) -> Unit) =
        ServerSocketChannel.open().bind(InetSocketAddress(host, port)).use(use)

    private fun from(local: SocketAddress, server: ServerSocketChannel, use: (SocketChannel) -> Unit) =
        SocketChannel.open().setOption(StandardSocketOptions.SO_REUSEADDR, true).bind(local).use { channel ->
            channel.connect(server.localAddress)
            server.accept().use { use(channel) }
        }

    private fun connected(use: (local: SocketChannel, peer: SocketChannel) -> Unit) {
        ServerSocketChannel.open().bind(InetSocketAddress(InetAddress.getLoopbackAddress(), 0)).use { server ->
            SocketChannel.open(server.localAddress).use { local -> server.accept().use { use(local, it) } }
        }
    }
}
