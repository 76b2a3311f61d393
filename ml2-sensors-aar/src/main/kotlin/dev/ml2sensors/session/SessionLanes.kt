package dev.ml2sensors.session

import dev.ml2sensors.wire.ErrorCode
import dev.ml2sensors.wire.FrameKind
import dev.ml2sensors.wire.Join
import dev.ml2sensors.wire.Joined
import dev.ml2sensors.wire.ProtocolException
import dev.ml2sensors.wire.Welcome
import kotlinx.coroutines.CoroutineScope
import kotlinx.coroutines.Dispatchers
import kotlinx.coroutines.Job
import kotlinx.coroutines.joinAll
import kotlinx.coroutines.launch
import kotlinx.coroutines.withTimeoutOrNull
import kotlin.time.Duration

/** The data lanes a session has joined, each with the connection it lends and the job that sends through it. */
internal class SessionLanes(
    private val welcome: Welcome,
    private val open: suspend (sendBufferBytes: Int?) -> Connection,
    private val lane: (String) -> Lane,
) {
    private val connections = HashMap<String, Connection>()
    private val senders = HashMap<String, Job>()

    /** Opens lane [name] unless it is open. */
    suspend fun join(name: String) {
        if (name in connections) return
        connections[name] = connect(name, if (name == SENSORS) null else IMAGE_SEND_BUFFER_BYTES)
    }

    /** Opens the time lane, which carries no data. */
    suspend fun joinTime(): Connection = connect(TIME, null)

    /** Begins to send what is offered to the lanes that are open. */
    fun startSending(scope: CoroutineScope) {
        for ((name, connection) in connections) {
            if (name in senders) continue
            senders[name] = scope.launch(Dispatchers.IO) {
                lane(name).sendThrough(connection.writer)
                connection.finishWriting()
            }
        }
    }

    /** Sends what is queued, for at most [limit], and ends the lanes; what is left is dropped and counted. */
    suspend fun finish(limit: Duration) {
        senders.keys.forEach { lane(it).finish() }
        withTimeoutOrNull(limit) { senders.values.joinAll() }
        senders.values.forEach { it.cancel() }
        senders.values.joinAll()
    }

    private suspend fun connect(name: String, sendBufferBytes: Int?): Connection {
        val ticket = welcome.tickets[name]
            ?: throw ProtocolException(ErrorCode.TICKET, "the receiver gave no ticket for lane $name")
        val connection = open(sendBufferBytes)
        val joined: Joined = handshake("JOINED of lane $name") {
            connection.write(FrameKind.JOIN, Join(welcome.session, ticket, name))
            connection.expect(FrameKind.JOINED)
        }
        if (joined.lane != name) {
            throw ProtocolException(ErrorCode.UNEXPECTED, "expected JOINED of lane $name, found ${joined.lane}")
        }
        return connection
    }

    companion object {
        const val TIME: String = "time"
        const val SENSORS: String = "sensors"

        /** Bounds how stale images grow in the kernel: a quarter of a raw world camera frame. */
        private const val IMAGE_SEND_BUFFER_BYTES = 256 * 1024
    }
}
