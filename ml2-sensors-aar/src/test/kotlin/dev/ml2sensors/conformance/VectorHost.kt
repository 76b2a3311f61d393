package dev.ml2sensors.conformance

import dev.ml2sensors.TEST_LIMIT
import dev.ml2sensors.session.HostFrame
import java.io.Closeable
import java.io.DataInputStream
import java.io.IOException
import java.net.InetAddress
import java.net.ServerSocket
import java.net.Socket
import java.nio.ByteBuffer
import java.nio.ByteOrder
import java.util.concurrent.ConcurrentHashMap
import java.util.concurrent.LinkedBlockingQueue
import java.util.concurrent.TimeUnit
import kotlin.concurrent.thread
import kotlin.test.assertFalse
import kotlin.test.assertNotNull

/** Plays vectors as a receiver on loopback, for one session; one thread reads each connection. */
internal class VectorHost : Closeable {
    private val server = ServerSocket(0, BACKLOG, InetAddress.getLoopbackAddress())
    private val lanes = ConcurrentHashMap<String, Socket>()
    private val received = LinkedBlockingQueue<HostFrame>()

    val port: Int get() = server.localPort

    /** True while TIME_REQUESTs are answered. A vector that is played on `time` stands alone there. */
    @Volatile
    var answersTime = true

    /** Takes the session to the state [given] of the README; in `connected` it waits for an answer on [lane]. */
    fun reach(given: String, lane: String, ros: Boolean = false) {
        if (accept("control", given, lane)) return
        play("control", Vector.load("wire", if (ros) "WelcomeRos" else "Welcome").bytes)
        for (name in listOf("time", "sensors") + if (ros) listOf("ros") else emptyList()) {
            if (accept(name, given, lane)) return
            play(name, joined(name))
        }
        // The device opens at once; await() would drop what comes before another kind.
        if (given == "opening" || given == "opened") repeat(OPENINGS.size) { await(HostFrame.OPEN) }
        if (given == "joined") return
        play("control", Vector.load("wire", "Configure").bytes)
        if (accept("world_left", given, lane)) return
        play("world_left", joined("world_left"))
        await(HostFrame.CONFIGURED)
        if (given == "configured") return
        play("control", Vector.load("wire", "Start").bytes)
        await(HostFrame.DATA)
        if (given != "opened") return
        for (body in OPENED) play("control", HostFrame.bytes(HostFrame.OPENED, body.toString().toByteArray()))
        accept("bulk_1", given, lane)
        play("bulk_1", joined("bulk_1"))
    }

    private fun accept(name: String, given: String, lane: String): Boolean {
        server.soTimeout = TEST_LIMIT.inWholeMilliseconds.toInt()
        val socket = server.accept()
        lanes[name] = socket
        val input = DataInputStream(socket.getInputStream())
        HostFrame.read(name, input)
        thread(isDaemon = true) { read(name, input) }
        return given == "connected" && name == lane
    }

    fun play(lane: String, bytes: ByteArray) {
        lanes.getValue(lane).getOutputStream().write(bytes)
    }

    fun shutdownOutput(lane: String) {
        lanes.getValue(lane).shutdownOutput()
    }

    /** The next frame of [kind] on any lane; or, for [HostFrame.END], the end of control. */
    fun await(kind: Int): HostFrame {
        val end = System.nanoTime() + TEST_LIMIT.inWholeNanoseconds
        var error = ""
        while (true) {
            val next = received.poll(end - System.nanoTime(), TimeUnit.NANOSECONDS)
            assertNotNull(next, "kind $kind did not come within $TEST_LIMIT")
            val isOver = next.kind == HostFrame.END && next.lane == "control"
            if (if (kind == HostFrame.END) isOver else next.kind == kind) return next
            if (next.kind == HostFrame.ERROR) error = ": ${next.json}"
            assertFalse(isOver, "control ended before kind $kind came$error")
        }
    }

    override fun close() {
        lanes.values.forEach(Socket::close)
        server.close()
    }

    private fun read(lane: String, input: DataInputStream) {
        try {
            while (true) {
                val frame = HostFrame.read(lane, input) ?: break
                val isAnswered = frame.kind == HostFrame.TIME_REQUEST && answersTime
                if (isAnswered) play(lane, timeReply(frame.body)) else received.put(frame)
            }
            received.put(HostFrame(lane, HostFrame.END))
        } catch (_: IOException) {
            received.put(HostFrame(lane, HostFrame.END))
        }
    }

    companion object {
        private val USES = listOf("", " bulk", " client", " service", " transform", " refused")

        /** The bodies by which the app opens, in order; the receiver refuses the last one. */
        val OPENINGS = USES.map { Vector.validBody("OPEN$it") }
        private val OPENED = USES.map { Vector.validBody("OPENED$it") }

        /** Only ends a test that hangs: on a busy machine, the first sessions have taken 35 s. */
        private const val BACKLOG = 16
        private const val TIMES_BYTES = 24
        private const val NANOS_PER_MILLI = 1_000_000L

        private fun timeReply(t1: ByteArray): ByteArray {
            val now = System.currentTimeMillis() * NANOS_PER_MILLI
            val times = ByteBuffer.allocate(TIMES_BYTES).order(ByteOrder.LITTLE_ENDIAN)
            return HostFrame.bytes(HostFrame.TIME_REPLY, times.put(t1).putLong(now).putLong(now).array())
        }

        private fun joined(lane: String) = HostFrame.bytes(HostFrame.JOINED, """{"lane": "$lane"}""".toByteArray())
    }
}
