package dev.ml2sensors.session

import dev.ml2sensors.pacing.ImagePacing
import dev.ml2sensors.table.StreamTable
import dev.ml2sensors.wire.ControlJson
import dev.ml2sensors.wire.ErrorCode
import dev.ml2sensors.wire.FrameKind
import dev.ml2sensors.wire.Join
import dev.ml2sensors.wire.Joined
import dev.ml2sensors.wire.ProtocolException
import dev.ml2sensors.wire.RosLanes
import dev.ml2sensors.wire.Welcome
import kotlinx.coroutines.Job
import kotlinx.coroutines.async
import kotlinx.coroutines.awaitAll
import kotlinx.coroutines.coroutineScope
import kotlinx.coroutines.joinAll
import kotlinx.coroutines.withContext
import kotlinx.coroutines.withTimeoutOrNull
import java.io.EOFException
import java.nio.channels.ClosedChannelException
import kotlin.time.Duration
import kotlin.time.Duration.Companion.seconds

/**
 * The data lanes of a session, each with its connection and the job that sends through it. Called by one coroutine at a
 * time.
 *
 * @param hasOpenings true if the session knows the kinds of openings.
 * @param launch runs a part of the session on a thread that may block.
 */
internal class SessionLanes(
    private val welcome: Welcome,
    private val hasOpenings: Boolean,
    private val open: suspend (urgent: Boolean, pacing: ImagePacing?) -> Connection,
    private val lane: (String) -> Lane,
    private val launch: (suspend () -> Unit) -> Job,
) {
    private val connections = HashMap<String, Connection>()
    private val senders = HashMap<String, Job>()

    /** Paces the lanes whose class is paced. */
    val pacing: ImagePacing = ImagePacing { lane(StreamTable.sensorsLane.name).isBlocked }

    val linkTest: LinkTest = LinkTest(launch) {
        connect(LINK_TEST, urgent = false).also { launch { watch(it) } }.writer
    }

    /** Opens those of the lanes [names] that are not open yet, concurrently. */
    suspend fun join(names: Set<String>) {
        val opened = coroutineScope {
            (names - connections.keys).map { async { it to joinData(it) } }.awaitAll()
        }
        connections += opened
        opened.forEach { (_, connection) -> launch { watch(connection) } }
    }

    private suspend fun joinData(name: String) =
        if (lane(name).spec.isPaced) connect(name, urgent = false, pacing) else connect(name, urgent = true)

    /** Waits for an ERROR, the only frame that may arrive. Other ends of a lane are reported on the control lane. */
    private suspend fun watch(connection: Connection) {
        try {
            blockingIo { connection.read(emptySet()) }
        } catch (_: ClosedChannelException) {
            // We closed it, to cut off a frame that could not be sent in time
        }
    }

    /** Opens the time lane, which carries no data. */
    suspend fun joinTime(): Connection = connect(TIME, urgent = true)

    /** Starts to send on all open lanes; returns when they accept frames. */
    suspend fun startSending() {
        for ((name, connection) in connections) {
            if (name in senders) continue
            val lane = lane(name)
            senders[name] = launch {
                withContext(if (lane.spec.isPaced) imageThreads else blockingThreads) {
                    lane.sendThrough(connection.writer)
                }
            }
            lane.awaitSession()
        }
    }

    /**
     * Sends queued frames for at most [limit] and ends the lanes; the rest is dropped and counted. A frame that is
     * being written may take [limit] again, since the receiver counts the end of a lane inside a frame as a loss. All
     * lanes end together: one that ends long before BYE would count as a loss too.
     */
    suspend fun finish(limit: Duration) {
        pacing.end()
        linkTest.finish(limit)
        senders.keys.forEach { lane(it).finish() }
        withTimeoutOrNull(limit) { senders.values.joinAll() }
        senders.keys.forEach { lane(it).dropQueued() }
        withTimeoutOrNull(limit) { senders.values.joinAll() }
        senders.values.forEach { it.cancel() }
        senders.values.joinAll()
        withTimeoutOrNull(limit) {
            for (name in senders.keys) blockingIo { connections.getValue(name).shutdownOutput() }
        }
    }

    /** Joins a lane of openings. */
    suspend fun connectToOpenings(name: String): Connection = connect(name, urgent = name == RosLanes.ROS)

    private suspend fun connect(name: String, urgent: Boolean, pacing: ImagePacing? = null): Connection {
        val ticket = welcome.tickets[name]
            ?: throw ProtocolException(ErrorCode.TICKET, "the receiver gave no ticket for lane $name")
        val connection = open(urgent, pacing)
        val join = ControlJson.encode(Join(welcome.session, ticket, name))
        val frame = handshake("JOINED of lane $name", welcome.timeouts.handshakeSeconds.seconds) {
            blockingIo {
                connection.writer.write(FrameKind.JOIN, join)
                connection.read(setOf(FrameKind.JOINED)) ?: throw EOFException("the receiver closed lane $name")
            }
        }
        val joined = ControlJson.decode<Joined>(frame.body)
        if (joined.lane != name) {
            throw ProtocolException(ErrorCode.UNEXPECTED, "expected JOINED of lane $name, found ${joined.lane}")
        }
        if (hasOpenings) connection.allowOpenings(RosLanes.maxMessageBytes(name))
        return connection
    }

    companion object {
        const val TIME: String = "time"
        const val LINK_TEST: String = "link_test"
    }
}
