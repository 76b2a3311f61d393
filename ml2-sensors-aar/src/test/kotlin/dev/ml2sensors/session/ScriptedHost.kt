package dev.ml2sensors.session

import dev.ml2sensors.TEST_LIMIT
import java.io.Closeable
import java.io.DataInputStream
import java.io.IOException
import java.net.InetAddress
import java.net.InetSocketAddress
import java.net.ServerSocket
import java.net.Socket
import java.util.concurrent.ConcurrentHashMap
import java.util.concurrent.CopyOnWriteArrayList
import java.util.concurrent.LinkedBlockingQueue
import java.util.concurrent.TimeUnit
import kotlin.concurrent.thread
import kotlin.test.assertEquals
import kotlin.test.assertNotNull

/**
 * A receiver by script on loopback: answers JOIN and TIME_REQUEST by itself, all else is the test's to say. It is
 * strict: [close] fails when the device broke the protocol. Waits are bounded; only failures take their whole limit.
 *
 * @param receiveBufferBytes of its sockets; small for a receiver that is soon full.
 * @param server not yet bound; plaintext or TLS.
 */
internal class ScriptedHost(
    receiveBufferBytes: Int? = null,
    private val server: ServerSocket = ServerSocket(),
) : Closeable {
    private val hellos = LinkedBlockingQueue<HostSession>()
    private val received = ConcurrentHashMap<String, Long>()
    private val breaches = CopyOnWriteArrayList<String>()

    /** ROS time of this host is System.nanoTime() plus this. */
    @Volatile
    var clockOffsetNanos = 1_700_000_000_000_000_000L

    /** True if it closes its side of control after the device's BYE. */
    var closesAfterBye = true

    /** Lanes whose JOIN and frames are not answered. */
    val silentLanes: MutableSet<String> = ConcurrentHashMap.newKeySet()

    /** The session that a JOIN belongs to. */
    @Volatile
    private var current: HostSession? = null

    val address: ReceiverAddress

    init {
        receiveBufferBytes?.let { server.receiveBufferSize = it }
        server.bind(InetSocketAddress(InetAddress.getLoopbackAddress(), 0), BACKLOG)
        address = ReceiverAddress("127.0.0.1", server.localPort)
        thread(isDaemon = true) { acceptAll() }
    }

    /** DATA frames that arrived so far over all sessions, by topic: `received` of WELCOME. */
    fun received(): Map<String, Long> = received.toMap()

    /** Waits for the next HELLO. */
    fun awaitHello(): HostSession {
        val session = assertNotNull(hellos.poll(TEST_LIMIT.inWholeMilliseconds, TimeUnit.MILLISECONDS), "no HELLO came")
        current = session
        return session
    }

    /** Waits for the next HELLO, asks for [streams] and starts them. */
    fun session(streams: String): HostSession = awaitHello().apply {
        welcome(received())
        configure(1, streams)
        start(1)
    }

    override fun close() {
        server.close()
        hellos.forEach { it.close() }
        current?.close()
        assertEquals(emptyList(), breaches, "breaches of the protocol")
    }

    private fun acceptAll() {
        while (true) {
            val socket = try {
                server.accept()
            } catch (_: IOException) {
                return
            }
            thread(isDaemon = true) { greet(socket) }
        }
    }

    private fun greet(socket: Socket) {
        val first = try {
            HostFrame.read("new", DataInputStream(socket.getInputStream()))
        } catch (_: IOException) {
            null
        }
        when (first?.kind) {
            HostFrame.HELLO -> hellos.put(HostSession(socket, first, this))
            HostFrame.JOIN -> current?.join(socket, first)
            null -> socket.close()
            else -> breach("first frame $first")
        }
    }

    fun breach(what: String) {
        breaches += what
    }

    fun count(topic: String) {
        received.merge(topic, 1, Long::plus)
    }

    fun rosNowNanos(): Long = System.nanoTime() + clockOffsetNanos

    companion object {
        private const val BACKLOG = 50
    }
}
