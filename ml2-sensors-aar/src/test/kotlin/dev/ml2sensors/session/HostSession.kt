package dev.ml2sensors.session

import dev.ml2sensors.TEST_LIMIT
import dev.ml2sensors.table.StreamTable
import kotlinx.serialization.json.JsonObject
import kotlinx.serialization.json.jsonObject
import kotlinx.serialization.json.jsonPrimitive
import java.io.DataInputStream
import java.io.IOException
import java.net.Socket
import java.nio.ByteBuffer
import java.nio.ByteOrder
import java.util.concurrent.ConcurrentHashMap
import java.util.concurrent.CopyOnWriteArrayList
import java.util.concurrent.CountDownLatch
import java.util.concurrent.locks.ReentrantLock
import kotlin.concurrent.thread
import kotlin.concurrent.withLock

/** One session of a [ScriptedHost], from HELLO on. One thread reads each connection into the log of frames. */
internal class HostSession(private val control: Socket, val hello: HostFrame, private val host: ScriptedHost) {
    private val sockets = ConcurrentHashMap<String, Socket>()
    private val readers = CopyOnWriteArrayList<Thread>()
    private val gates = ConcurrentHashMap<String, CountDownLatch>()
    private val lock = ReentrantLock()
    private val grown = lock.newCondition()
    private val log = ArrayList<HostFrame>()

    // A search through all of a fast sensor's frames, for each new one, would keep the lock from the readers.
    private val ofKind = HashMap<Int, MutableList<HostFrame>>()
    private val ofTopic = HashMap<String, MutableList<HostFrame>>()
    private val judge = ProtocolJudge(host)

    init {
        begin("control", control)
    }

    fun welcome(
        received: Map<String, Long>? = null,
        version: Int = 1,
        lanes: List<String> = listOf("time", "sensors", "link_test") + StreamTable.all.map { it.id },
        timeouts: String = """{"handshake_s": $LIMIT_S, "ping_s": 1, "dead_s": $LIMIT_S}""",
        ros: Boolean = false,
    ) {
        val ofOpenings = if (ros) listOf("ros", "bulk_1", "bulk_2", "bulk_3", "bulk_4") else emptyList()
        val uses = listOf("subscribe", "publish", "call", "offer").joinToString { "\"$it\": true" }
        val more = if (ros) ", \"ros\": {$uses}" else ""
        val tickets = (lanes + ofOpenings).joinToString { """"$it": "${ticket(it)}"""" }
        val counts = received?.entries?.joinToString(prefix = "{", postfix = "}") { """"${it.key}": ${it.value}""" }
        write(
            HostFrame.WELCOME,
            """{"version": $version, "session": "$SESSION", "name": "scripted", "software": "test", "later": [null],
                "tickets": {$tickets}, "received": $counts, "limits": {"data_bytes": 16777216}, "timeouts": $timeouts $more}""",
        )
    }

    /** Sends CONFIGURE and waits for its answer, by stream. */
    fun configure(request: Long, streams: String, framePrefix: String = ""): JsonObject {
        val before = frames(HostFrame.CONFIGURED).size
        write(HostFrame.CONFIGURE, """{"request": $request, "streams": $streams, "frame_prefix": "$framePrefix"}""")
        return await(HostFrame.CONFIGURED, before).json.getValue("streams").jsonObject
    }

    fun start(request: Long) {
        val channels = lock.withLock {
            judge.start()
            ofKind[HostFrame.CHANNEL].orEmpty().size
        }
        write(HostFrame.START, """{"request": $request, "channels": $channels}""")
    }

    /** Sends LINK_TEST. */
    fun testLink(bytes: Int) {
        lock.withLock { judge.testLink(bytes) }
        write(HostFrame.LINK_TEST, """{"bytes": $bytes}""")
    }

    /** The filler up to the end of link test number [index], counted from 0. */
    fun awaitFiller(index: Int = 0): List<HostFrame> = awaitLog("the end of link test $index") {
        val filler = ofKind[HostFrame.FILLER].orEmpty().toList()
        val ends = filler.indices.filter { filler[it].body.isEmpty() }
        ends.getOrNull(index)?.let { filler.subList(0, it + 1) }
    }

    fun write(kind: Int, json: String = "", lane: String = "control") {
        sockets.getValue(lane).getOutputStream().write(HostFrame.bytes(kind, json.toByteArray()))
    }

    /** Sends a MESSAGE of the opening [id]. */
    fun message(id: Int, number: Int, payload: ByteArray, publishedNanos: Long = 0, lane: String = "ros") =
        send(HostFrame.MESSAGE, id, number, payload, publishedNanos, lane)

    /** Sends a frame of the opening [id]. */
    fun send(kind: Int, id: Int, number: Int, body: ByteArray, captureNanos: Long = 0, lane: String = "ros") {
        val frame = HostFrame.bytes(kind, body, id, number, captureNanos)
        awaitLog("JOIN of $lane") { ofKind[HostFrame.JOIN]?.find { it.lane == lane } }
        val socket = sockets.getValue(lane)
        synchronized(socket) { socket.getOutputStream().write(frame) }
    }

    /** Waits for the TAKEN of message [number] of the opening [id]. */
    fun awaitTaken(id: Int, number: Long): HostFrame = awaitLog("TAKEN of $number") {
        ofKind[HostFrame.TAKEN]?.find { it.channel == id && it.sequence == number }
    }

    /** The frame number [index] of [kind], counted from 0 over all lanes. */
    fun await(kind: Int, index: Int = 0): HostFrame =
        awaitLog("$kind") { ofKind[kind]?.getOrNull(index) }

    fun awaitEnd(lane: String): HostFrame =
        awaitLog("end of $lane") { ofKind[HostFrame.END]?.find { it.lane == lane } }

    /** Waits until the device has closed every lane: all that it sent is in the log. */
    fun awaitEnds() = readers.forEach(Thread::join)

    /** At least [count] messages of [topic], in order. */
    fun awaitData(topic: String, count: Int = 1): List<HostFrame> =
        awaitLog("$count of $topic") { ofTopic[topic]?.takeIf { it.size >= count }?.toList() }

    /** Messages of [topic] so far, in order. */
    fun data(topic: String): List<HostFrame> = lock.withLock { ofTopic[topic].orEmpty().toList() }

    fun frames(kind: Int): List<HostFrame> = lock.withLock { ofKind[kind].orEmpty().toList() }

    /** CHANNEL bodies by topic. */
    fun channels(): Map<String, JsonObject> =
        frames(HostFrame.CHANNEL).map { it.json }.associateBy { it.getValue("topic").jsonPrimitive.content }

    fun log(): List<HostFrame> = lock.withLock { log.toList() }

    /** Reads nothing of [lane] until [release]; to be called before the lane is joined. */
    fun hold(lane: String) {
        gates[lane] = CountDownLatch(1)
    }

    fun release(lane: String) = gates.getValue(lane).countDown()

    /** Breaks all connections, as a link does; what had not been read is lost. */
    fun cut() {
        sockets.values.forEach {
            it.setSoLinger(true, 0)
            it.close()
        }
        finishReaders()
    }

    /** Closes all connections. */
    fun close() {
        sockets.values.forEach(Socket::close)
        finishReaders()
    }

    fun closeOutput(lane: String) = sockets.getValue(lane).shutdownOutput()

    private fun finishReaders() {
        gates.values.forEach(CountDownLatch::countDown)
        readers.forEach(Thread::join)
    }

    fun join(socket: Socket, frame: HostFrame) {
        val lane = frame.json.getValue("lane").jsonPrimitive.content
        val expected = """{"session":"$SESSION","ticket":"${ticket(lane)}","lane":"$lane"}"""
        if (frame.body.decodeToString() != expected) host.breach("JOIN $frame")
        if (sockets.putIfAbsent(lane, socket) != null) host.breach("lane $lane is joined twice")
        synchronized(socket) {
            record(HostFrame(lane, frame.kind, body = frame.body))
            if (lane in host.silentLanes) return
            begin(lane, socket)
            write(HostFrame.JOINED, """{"lane": "$lane"}""", lane)
        }
    }

    private fun begin(lane: String, socket: Socket) {
        sockets[lane] = socket
        readers += thread(isDaemon = true) { read(lane, socket) }
    }

    private fun read(lane: String, socket: Socket) {
        try {
            val input = DataInputStream(socket.getInputStream())
            while (true) {
                gates[lane]?.await()
                val frame = HostFrame.read(lane, input) ?: break
                if (frame.kind == HostFrame.TIME_REQUEST) answerTime(frame) else record(frame)
            }
            record(HostFrame(lane, HostFrame.END, body = "end".toByteArray()))
            if (lane == "control" && host.closesAfterBye && frames(HostFrame.BYE).isNotEmpty()) socket.shutdownOutput()
        } catch (e: IOException) {
            record(HostFrame(lane, HostFrame.END, body = "$e".toByteArray()))
        }
    }

    private fun answerTime(request: HostFrame) {
        val now = host.rosNowNanos()
        val reply = ByteBuffer.allocate(24).order(ByteOrder.LITTLE_ENDIAN).put(request.body).putLong(now).putLong(now)
        if ("time" in host.silentLanes) return
        sockets.getValue("time").getOutputStream().write(HostFrame.bytes(HostFrame.TIME_REPLY, reply.array()))
    }

    private fun record(frame: HostFrame) = lock.withLock {
        log += frame
        ofKind.getOrPut(frame.kind, ::ArrayList) += frame
        judge.judge(frame)
        if (frame.kind == HostFrame.DATA) {
            judge.topic(frame.channel)?.let {
                ofTopic.getOrPut(it, ::ArrayList) += frame
                host.count(it)
            }
        }
        grown.signalAll()
    }

    private fun <T : Any> awaitLog(what: String, find: () -> T?): T = lock.withLock {
        var leftNanos = TEST_LIMIT.inWholeNanoseconds
        var found = find()
        while (found == null) {
            if (leftNanos <= 0) throw AssertionError("awaited $what, found\n${log.takeLast(10).joinToString("\n")}")
            leftNanos = grown.awaitNanos(leftNanos)
            found = find()
        }
        found
    }

    companion object {
        private val LIMIT_S = TEST_LIMIT.inWholeSeconds
        const val SESSION = "5e5510000000000000000000000000ff"

        fun ticket(lane: String): String = lane.hashCode().toUInt().toString(16).padStart(32, '0')
    }
}
