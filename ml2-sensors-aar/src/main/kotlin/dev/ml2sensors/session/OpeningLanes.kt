package dev.ml2sensors.session

import dev.ml2sensors.wire.Closed
import dev.ml2sensors.wire.ControlJson
import dev.ml2sensors.wire.Frame
import dev.ml2sensors.wire.FrameKind
import dev.ml2sensors.wire.Open
import dev.ml2sensors.wire.Opened
import dev.ml2sensors.wire.RosLanes
import kotlinx.coroutines.Job
import kotlinx.coroutines.sync.Mutex
import kotlinx.coroutines.sync.withLock
import kotlinx.coroutines.withTimeoutOrNull
import java.nio.channels.ClosedChannelException
import kotlin.time.Duration

/** What the app of a session has [wanted], and what takes the frames that come for it. */
internal class AppOpenings(val wanted: List<Open>, val deliver: (Frame) -> Unit)

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
    private val connections = HashMap<String, Connection>()
    private val joining = Mutex()
    private val openings = Openings(app.deliver)

    /** Opens what the app wants. */
    suspend fun open() {
        join(RosLanes.ROS)
        for (wanted in app.wanted) {
            openings.asks(wanted)
            control.write(FrameKind.OPEN, wanted)
        }
    }

    /** Takes an OPENED or CLOSED; never waits. */
    fun received(frame: Frame) {
        if (frame.kind == FrameKind.CLOSED) return openings.closed(ControlJson.decode<Closed>(frame.body))
        val opened = ControlJson.decode<Opened>(frame.body)
        openings.opened(opened)
        if (opened.isOpen && opened.lane != null && opened.lane != RosLanes.ROS) launch { join(opened.lane) }
    }

    private suspend fun join(name: String): Unit = joining.withLock {
        if (name in connections) return
        val connection = connect(name)
        connections[name] = connection
        launch { read(name, connection) }
    }

    /** Ends the output, so that the receiver finds the end of each lane; takes at most [limit]. */
    suspend fun finish(limit: Duration) {
        withTimeoutOrNull(limit) {
            joining.withLock { connections.values.forEach { blockingIo { it.shutdownOutput() } } }
        }
    }

    /** Reads until the lane ends, for which the control lane has the reason. */
    private suspend fun read(name: String, connection: Connection) {
        val allowed = if (name == RosLanes.ROS) ON_ROS else ON_BULK
        try {
            while (true) {
                val frame = blockingIo { connection.read(allowed) } ?: return
                val failure = openings.received(name, frame) ?: continue
                val body = ControlJson.encode(failure)
                val (channel, number) = frame.header.channel to frame.header.sequence
                blockingIo { connection.writer.write(FrameKind.FAILURE, body, channel, number) }
            }
        } catch (_: ClosedChannelException) {
            // The session has ended
        }
    }

    companion object {
        /** What the receiver sends on the control lane. */
        val ON_CONTROL: Set<FrameKind> = setOf(FrameKind.OPENED, FrameKind.CLOSED)
        private val ON_BULK = setOf(FrameKind.MESSAGE)
        private val ON_ROS =
            ON_BULK + setOf(FrameKind.POSE, FrameKind.REQUEST, FrameKind.RESPONSE, FrameKind.FAILURE)
    }
}
