package dev.ml2sensors.session

import dev.ml2sensors.wire.ControlJson
import dev.ml2sensors.wire.ErrorCode
import dev.ml2sensors.wire.FrameKind
import dev.ml2sensors.wire.Join
import dev.ml2sensors.wire.Joined
import dev.ml2sensors.wire.ProtocolException
import dev.ml2sensors.wire.Welcome
import kotlinx.coroutines.Job
import kotlinx.coroutines.async
import kotlinx.coroutines.awaitAll
import kotlinx.coroutines.coroutineScope
import kotlinx.coroutines.joinAll
import kotlinx.coroutines.withTimeoutOrNull
import java.io.EOFException
import java.nio.channels.ClosedChannelException
import kotlin.time.Duration
import kotlin.time.Duration.Companion.seconds

/**
 * The data lanes a session has joined, each with the connection it lends and the job that sends through it.
 *
 * @param launch runs a part of the session on a thread that may block.
 */
internal class SessionLanes(
    private val welcome: Welcome,
    private val open: suspend (urgent: Boolean) -> Connection,
    private val lane: (String) -> Lane,
    private val launch: (suspend () -> Unit) -> Job,
) {
    private val connections = HashMap<String, Connection>()
    private val senders = HashMap<String, Job>()

    val linkTest: LinkTest = LinkTest(launch) {
        connect(LINK_TEST, urgent = false).also { launch { watch(it) } }.writer
    }

    /** Opens those of the lanes [names] that are not open, beside each other. */
    suspend fun join(names: Set<String>) {
        val opened = coroutineScope {
            (names - connections.keys).map { async { it to connect(it, urgent = it == SENSORS) } }.awaitAll()
        }
        connections += opened
        opened.forEach { (_, connection) -> launch { watch(connection) } }
    }

    /** Nothing but an ERROR may come; why a lane ends is for the control lane to say. */
    private suspend fun watch(connection: Connection) {
        try {
            blockingIo { connection.read(emptySet()) }
        } catch (_: ClosedChannelException) {
            // We closed it, to cut off a frame that could not be sent in time
        }
    }

    /** Opens the time lane, which carries no data. */
    suspend fun joinTime(): Connection = connect(TIME, urgent = true)

    /** Begins to send what is offered to the lanes that are open; returns when none of it can miss its link. */
    suspend fun startSending() {
        for ((name, connection) in connections) {
            if (name in senders) continue
            senders[name] = launch { lane(name).sendThrough(connection.writer) }
            lane(name).awaitSession()
        }
    }

    /**
     * Sends what is queued, for at most [limit], and ends the lanes; what is left is dropped and counted. Frames under
     * way may take [limit] again, since the receiver takes the end of a lane inside a frame for a loss. Lanes end
     * together, since it takes one that ends long before BYE for a loss too.
     */
    suspend fun finish(limit: Duration) {
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

    private suspend fun connect(name: String, urgent: Boolean): Connection {
        val ticket = welcome.tickets[name]
            ?: throw ProtocolException(ErrorCode.TICKET, "the receiver gave no ticket for lane $name")
        val connection = open(urgent)
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
        return connection
    }

    companion object {
        const val TIME: String = "time"
        const val SENSORS: String = "sensors"
        const val LINK_TEST: String = "link_test"
    }
}
