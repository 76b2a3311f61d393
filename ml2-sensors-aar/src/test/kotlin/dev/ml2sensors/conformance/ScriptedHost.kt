package dev.ml2sensors.conformance

import kotlinx.serialization.json.Json
import kotlinx.serialization.json.JsonObject
import kotlinx.serialization.json.jsonObject
import kotlinx.serialization.json.jsonPrimitive
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

/** A receiver played by hand on loopback, with its own idea of the header; one thread reads each connection. Serves one session. */
internal class ScriptedHost : Closeable {
    class Received(val lane: String, val kind: Int, val body: ByteArray) {
        val json: JsonObject get() = Json.parseToJsonElement(body.decodeToString()).jsonObject
    }

    private val server = ServerSocket(0, BACKLOG, InetAddress.getLoopbackAddress())
    private val lanes = ConcurrentHashMap<String, Socket>()
    private val received = LinkedBlockingQueue<Received>()

    val port: Int get() = server.localPort

    /** Whether TIME_REQUESTs are answered; a vector that is played on `time` stands alone there. */
    @Volatile
    var answersTime = true

    /** Takes the session to the state [given] of the README; in `connected` it waits for an answer on [lane]. */
    fun reach(given: String, lane: String) {
        if (accept("control", given, lane)) return
        play("control", Vector.load("wire", "Welcome").bytes)
        for (name in listOf("time", "sensors")) {
            if (accept(name, given, lane)) return
            play(name, joined(name))
        }
        if (given == "joined") return
        play("control", Vector.load("wire", "Configure").bytes)
        if (accept("world_left", given, lane)) return
        play("world_left", joined("world_left"))
        await(CONFIGURED)
        if (given == "configured") return
        play("control", Vector.load("wire", "Start").bytes)
        await(DATA)
    }

    private fun accept(name: String, given: String, lane: String): Boolean {
        server.soTimeout = LIMIT_MILLIS
        val socket = server.accept()
        lanes[name] = socket
        val input = DataInputStream(socket.getInputStream())
        readFrame(name, input)
        thread(isDaemon = true) { read(name, input) }
        return given == "connected" && name == lane
    }

    fun play(lane: String, bytes: ByteArray) {
        lanes.getValue(lane).getOutputStream().write(bytes)
    }

    fun finishWriting(lane: String) {
        lanes.getValue(lane).shutdownOutput()
    }

    /** The next frame of [kind] on any lane; or, for [END], the end of control. */
    fun await(kind: Int): Received {
        val end = System.nanoTime() + LIMIT_MILLIS * NANOS_PER_MILLI
        while (true) {
            val next = received.poll(end - System.nanoTime(), TimeUnit.NANOSECONDS)
            assertNotNull(next, "kind $kind did not come within $LIMIT_MILLIS ms")
            val isOver = next.kind == END && next.lane == "control"
            if (if (kind == END) isOver else next.kind == kind) return next
            assertFalse(isOver, "control ended before kind $kind came")
        }
    }

    override fun close() {
        lanes.values.forEach(Socket::close)
        server.close()
    }

    private fun read(lane: String, input: DataInputStream) {
        try {
            while (true) {
                val frame = readFrame(lane, input)
                if (frame.kind == TIME_REQUEST &&
                    answersTime
                ) {
                    play(lane, timeReply(frame.body))
                } else {
                    received.put(frame)
                }
            }
        } catch (_: IOException) {
            received.put(Received(lane, END, byteArrayOf()))
        }
    }

    companion object {
        const val CONFIGURED = 6
        const val DATA = 16
        const val TIME_REQUEST = 32
        const val TIME_REPLY = 33
        const val PING = 49
        const val PONG = 50
        const val ERROR = 51

        /** In place of a kind: the connection has ended. */
        const val END = -1
        private const val LIMIT_MILLIS = 8_000
        private const val BACKLOG = 16
        private const val HEADER_BYTES = 32
        private const val TIMES_BYTES = 24
        private const val NANOS_PER_MILLI = 1_000_000L

        fun frame(kind: Int, body: ByteArray): ByteArray = ByteBuffer
            .allocate(HEADER_BYTES + body.size)
            .order(ByteOrder.LITTLE_ENDIAN)
            .putShort(0x324D)
            .put(1)
            .put(kind.toByte())
            .putLong(0) // flags, channel, sequence
            .putInt(body.size)
            .putLong(0) // capture
            .putLong(0) // send
            .put(body)
            .array()

        private fun timeReply(t1: ByteArray): ByteArray {
            val now = System.currentTimeMillis() * NANOS_PER_MILLI
            val times = ByteBuffer.allocate(TIMES_BYTES).order(ByteOrder.LITTLE_ENDIAN)
            return frame(TIME_REPLY, times.put(t1).putLong(now).putLong(now).array())
        }

        private fun joined(lane: String) = frame(kind = 4, """{"lane": "$lane"}""".toByteArray())

        private fun readFrame(lane: String, input: DataInputStream): Received {
            val header = ByteArray(HEADER_BYTES).also(input::readFully)
            val fields = ByteBuffer.wrap(header).order(ByteOrder.LITTLE_ENDIAN)
            val body = ByteArray(fields.getInt(12)).also(input::readFully)
            return Received(lane, fields.get(3).toInt(), body)
        }
    }
}
