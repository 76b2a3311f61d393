package dev.ml2sensors.transport

import dev.ml2sensors.capture.Simulation
import org.junit.jupiter.api.Test
import java.net.InetAddress
import java.net.InetSocketAddress
import java.nio.ByteBuffer
import java.nio.channels.ServerSocketChannel
import java.nio.channels.SocketChannel
import kotlin.test.assertEquals
import kotlin.test.assertNotNull

/** With the library of the headset, and real connections. */
class SendQueueTest {
    init {
        Simulation.begin()
    }

    @Test
    fun whatThePeerCannotTakeIsHeldAndThenGone() = connected { local, peer ->
        local.configureBlocking(false)
        var writtenBytes = 0
        while (true) {
            val count = local.write(ByteBuffer.allocate(1 shl 16))
            if (count == 0) break
            writtenBytes += count
        }
        val queue = assertNotNull(SendQueue.of(local))
        assert(queue.bytes in 1..<writtenBytes) { "${queue.bytes} of $writtenBytes bytes" }
        val taken = ByteBuffer.allocate(writtenBytes)
        while (taken.hasRemaining()) peer.read(taken)
        while (queue.bytes > 0) Thread.onSpinWait()
    }

    @Test
    fun eachConnectionHasItsOwn() = connected { local, _ ->
        connected { other, _ ->
            other.write(ByteBuffer.allocate(100_000))
            assertEquals(0, assertNotNull(SendQueue.of(local)).bytes)
        }
    }

    private fun connected(use: (local: SocketChannel, peer: SocketChannel) -> Unit) {
        ServerSocketChannel.open().bind(InetSocketAddress(InetAddress.getLoopbackAddress(), 0)).use { server ->
            SocketChannel.open(server.localAddress).use { local -> server.accept().use { use(local, it) } }
        }
    }
}
