package dev.ml2sensors.session

import dev.ml2sensors.wire.Close
import dev.ml2sensors.wire.Closed
import dev.ml2sensors.wire.ControlJson
import dev.ml2sensors.wire.Frame
import dev.ml2sensors.wire.FrameHeader
import dev.ml2sensors.wire.FrameKind
import dev.ml2sensors.wire.Open
import dev.ml2sensors.wire.Opened
import dev.ml2sensors.wire.RosLanes
import dev.ml2sensors.wire.Status
import kotlinx.coroutines.Job
import kotlinx.coroutines.channels.Channel
import kotlinx.coroutines.channels.Channel.Factory.UNLIMITED
import kotlinx.coroutines.coroutineScope
import kotlinx.coroutines.launch
import kotlinx.coroutines.sync.Mutex
import kotlinx.coroutines.sync.withLock
import kotlinx.coroutines.withContext
import kotlinx.coroutines.withTimeoutOrNull
import java.io.IOException
import java.nio.channels.ClosedChannelException
import java.util.concurrent.ConcurrentHashMap
import java.util.concurrent.atomic.AtomicInteger
import kotlin.time.Duration

/** The openings of an app, over all sessions. Called by several threads; nothing but [serve] waits. */
internal interface AppOpenings {
    /** Opens and closes on [lanes] until the session ends; null is a session whose receiver serves no openings. */
    suspend fun serve(lanes: OpeningLanes?)

    /** Takes the answer to an OPEN. */
    fun opened(answer: Opened)

    /** Takes the end of an opening. */
    fun closed(end: Closed)

    /** Takes a frame of an opening, and calls [left] when it leaves its queue; returns false if the app has closed it. */
    fun take(frame: Frame, left: () -> Unit): Boolean

    /** Returns the counters of the present session's subscriptions by id, as in STATUS. */
    fun counts(): Map<String, Status.OpeningCounts> = emptyMap()

    /** Returns the counters of the present session's clients and services by id, as in STATUS. */
    fun calls(): Map<String, Status.CallCounts> = emptyMap()
}

/** The openings of an app of several kinds. */
internal class AllOpenings(private vararg val parts: AppOpenings) : AppOpenings {
    override suspend fun serve(lanes: OpeningLanes?): Unit = coroutineScope {
        for (part in parts) launch { part.serve(lanes) }
    }

    override fun opened(answer: Opened): Unit = parts.forEach { it.opened(answer) }

    override fun closed(end: Closed): Unit = parts.forEach { it.closed(end) }

    override fun take(frame: Frame, left: () -> Unit): Boolean = parts.any { it.take(frame, left) }

    override fun counts(): Map<String, Status.OpeningCounts> =
        parts.fold(emptyMap()) { counts, part -> counts + part.counts() }

    override fun calls(): Map<String, Status.CallCounts> =
        parts.fold(emptyMap()) { counts, part -> counts + part.calls() }
}

/**
 * The lanes of the openings of a session: `ros` for small frames and `bulk_1` to `bulk_4` for large messages, each with
 * a thread that reads it.
 *
 * @param connect joins the lane of this name.
 * @param launch runs a part of the session on a thread that may block.
 */
internal class OpeningLanes(
    private val control: ControlLane,
    private val app: AppOpenings,
    private val connect: suspend (String) -> Connection,
    private val launch: (suspend () -> Unit) -> Job,
) {
    private val ids = AtomicInteger()
    private val connections = ConcurrentHashMap<String, Connection>()
    private val joining = Mutex()
    private val openings =
        Openings(deliver = { lane, frame -> app.take(frame) { taken(lane, frame) } }, discarded = ::taken)

    /** The messages of lanes `bulk_N` that have left their queues, by lane. */
    private val taken = ConcurrentHashMap<String, Channel<FrameHeader>>()

    suspend fun open(wanted: Open) {
        join(RosLanes.ROS)
        openings.asks(wanted)
        control.write(FrameKind.OPEN, wanted)
    }

    suspend fun close(id: Int): Unit = control.write(FrameKind.CLOSE, Close(id))

    /**
     * Returns a number for the next [open].
     *
     * @throws IOException if this session has had them all; the next one begins anew.
     */
    fun nextId(): Int {
        val id = ids.incrementAndGet()
        if (id > MOST_IDS) throw IOException("this session has had $MOST_IDS openings, the most")
        return id
    }

    /** Sends a REQUEST of a client that is open. Requests of a client are sent by one coroutine, in their order. */
    suspend fun request(id: Int, number: Int, payload: ByteArray, limitNanos: Long) {
        openings.asks(id, number)
        val ros = connections.getValue(RosLanes.ROS).writer
        blockingIo { ros.write(FrameKind.REQUEST, payload, id, number, limitNanos) }
    }

    /** Sends the RESPONSE or FAILURE to a REQUEST of the receiver, unless the session is over. */
    suspend fun answer(id: Int, number: Int, kind: FrameKind, body: ByteArray) {
        openings.answered(id, number)
        try {
            blockingIo { connections.getValue(RosLanes.ROS).writer.write(kind, body, id, number) }
        } catch (_: IOException) {
            // The reader of the lane has the reason
        }
    }

    /** As [AppOpenings.counts]. */
    fun counts(): Map<String, Status.OpeningCounts> = app.counts()

    /** As [AppOpenings.calls]. */
    fun calls(): Map<String, Status.CallCounts> = app.calls()

    /** Takes an OPENED or CLOSED; never waits. */
    fun received(frame: Frame) {
        if (frame.kind == FrameKind.CLOSED) {
            val end = ControlJson.decode<Closed>(frame.body)
            openings.closed(end)
            return app.closed(end)
        }
        val opened = ControlJson.decode<Opened>(frame.body)
        openings.opened(opened)
        app.opened(opened)
        if (opened.isOpen && opened.lane != null && opened.lane != RosLanes.ROS) launch { join(opened.lane) }
    }

    private suspend fun join(name: String): Unit = joining.withLock {
        if (connections.containsKey(name)) return
        val connection = connect(name)
        connections[name] = connection
        if (name != RosLanes.ROS) {
            val left = Channel<FrameHeader>(UNLIMITED)
            taken[name] = left // before a message can leave a queue
            launch { sayTaken(connection, left) }
        }
        launch { withContext(if (name == RosLanes.ROS) blockingThreads else imageThreads) { read(name, connection) } }
    }

    /** Takes note of a [frame] that is in no queue any more; never waits. */
    private fun taken(lane: String, frame: Frame) {
        taken[lane]?.trySend(frame.header)
    }

    private suspend fun sayTaken(connection: Connection, taken: Channel<FrameHeader>) {
        try {
            for (message in taken) {
                val (id, number) = message.channel to message.sequence
                if (openings.taken(id, number)) {
                    blockingIo {
                        connection.writer.write(FrameKind.TAKEN, NOTHING, id, number)
                    }
                }
            }
        } catch (_: IOException) {
            // The reader of the lane has the reason
        }
    }

    /** Ends the output, so that the receiver finds the end of each lane; takes at most [limit]. */
    suspend fun finish(limit: Duration) {
        withTimeoutOrNull(limit) {
            joining.withLock { connections.values.forEach { blockingIo { it.shutdownOutput() } } }
        }
        taken.values.forEach { it.close() }
    }

    /** Reads until the lane ends, for which the control lane has the reason. */
    private suspend fun read(name: String, connection: Connection) {
        val allowed = if (name == RosLanes.ROS) ON_ROS else ON_BULK
        try {
            while (true) {
                val frame = blockingIo { connection.read(allowed) } ?: return
                val failure = openings.received(name, frame) ?: continue
                answer(frame.header.channel, frame.header.sequence, FrameKind.FAILURE, ControlJson.encode(failure))
            }
        } catch (_: ClosedChannelException) {
            // The session has ended
        }
    }

    companion object {
        /** The kinds that the receiver sends on the control lane. */
        val ON_CONTROL: Set<FrameKind> = setOf(FrameKind.OPENED, FrameKind.CLOSED)
        private const val MOST_IDS = 0xFFFF
        private val NOTHING = ByteArray(0)
        private val ON_BULK = setOf(FrameKind.MESSAGE)
        private val ON_ROS =
            ON_BULK + setOf(FrameKind.POSE, FrameKind.REQUEST, FrameKind.RESPONSE, FrameKind.FAILURE)
    }
}
