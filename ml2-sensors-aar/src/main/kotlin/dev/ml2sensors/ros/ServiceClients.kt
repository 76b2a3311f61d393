package dev.ml2sensors.ros

import dev.ml2sensors.cdr.Cdr
import dev.ml2sensors.cdr.layout
import dev.ml2sensors.message.ServiceType
import dev.ml2sensors.session.AppOpenings
import dev.ml2sensors.session.OpeningLanes
import dev.ml2sensors.wire.Closed
import dev.ml2sensors.wire.ControlJson
import dev.ml2sensors.wire.Failure
import dev.ml2sensors.wire.Frame
import dev.ml2sensors.wire.FrameKind
import dev.ml2sensors.wire.Open
import dev.ml2sensors.wire.Opened
import dev.ml2sensors.wire.Status
import dev.ml2sensors.wire.isShort
import dev.ml2sensors.wire.printable
import kotlinx.coroutines.CompletableDeferred
import kotlinx.coroutines.channels.Channel
import kotlinx.coroutines.withTimeoutOrNull
import kotlinx.serialization.ExperimentalSerializationApi
import java.nio.ByteBuffer
import kotlin.time.Duration
import kotlin.time.TimeMark
import kotlin.time.TimeSource

/**
 * Calls one service of ROS. Thread-safe. It uses one of the 64 openings of an app from its first [call] in a session on,
 * until it is closed.
 */
public class ServiceClient<Q, A> internal constructor(
    private val clients: ServiceClients,
    internal val service: String,
    private val type: ServiceType<Q, A>,
) : AutoCloseable {
    @OptIn(ExperimentalSerializationApi::class)
    private val layout = "${type.request.descriptor.layout()}>${type.response.descriptor.layout()}"

    /** Used under the lock of [clients]. */
    internal var isClosed = false

    init {
        require(isShort(service, MOST_CHARACTERS)) {
            "service: expected 1 to $MOST_CHARACTERS printable characters, found '${printable(service)}'"
        }
        require(isShort(type.name, MOST_CHARACTERS) && TYPE.matches(type.name)) {
            "expected a ROS type such as std_srvs/srv/SetBool, found '${type.name}'"
        }
        val bytes = ControlJson.encode(Open.serializer(), open(MOST_ID)).size
        require(bytes <= FrameKind.OPEN.maxLength) {
            "${type.name} has too many fields: OPEN has room for ${FrameKind.OPEN.maxLength} bytes, found $bytes"
        }
    }

    internal fun open(id: Int) = Open(id, Open.CLIENT, service, type.name, layout = layout)

    /**
     * Returns the response to [request]. Each call ends with the response or one exception, within [timeout]. Without a
     * connection it waits for one that long.
     *
     * @throws ServiceException if there is no response.
     * @throws IllegalArgumentException if [timeout] is not above zero, or the request has no CDR.
     */
    public suspend fun call(request: Q, timeout: Duration): A {
        require(timeout.isPositive()) { "timeout: expected more than 0, found $timeout" }
        val payload = Cdr.encodeToByteArray(type.request, request)
        if (payload.size > FrameKind.REQUEST.maxLength) {
            val found = "a request of ${payload.size} bytes, expected at most ${FrameKind.REQUEST.maxLength}"
            throw ServiceException(ServiceException.Reason.TOO_LARGE, "$service: $found")
        }
        val response = clients.response(this, payload, timeout)
        return try {
            Cdr.decode(type.response, ByteBuffer.wrap(response), allowsTail = true)
        } catch (e: IllegalArgumentException) { // SerializationException is one
            throw ServiceException(ServiceException.Reason.MALFORMED, "$service: ${e.message}")
        }
    }

    /** Ends the client. Calls that are under way fail, as do later ones. */
    override fun close(): Unit = clients.close(this)

    private companion object {
        const val MOST_ID = 0xFFFF
        const val MOST_CHARACTERS = 255
        val TYPE = Regex("[a-z][a-z0-9_]*/srv/[A-Z][A-Za-z0-9]*")
    }
}

/** One call; [number] is that of its REQUEST, null before. */
private class Call(val client: ServiceClient<*, *>, val payload: ByteArray, val due: TimeMark) {
    val response = CompletableDeferred<ByteArray>()
    var id = 0
    var number: Int? = null

    fun fail(error: ServiceException) {
        response.completeExceptionally(error)
    }
}

/** The service clients of an app, over all sessions of its streamer. Thread-safe. */
internal class ServiceClients : AppOpenings {
    private val changes = Channel<Unit>(Channel.CONFLATED)

    /** In the order of the calls: those that were not sent, and those that were. */
    private val calls = LinkedHashSet<Call>()

    /** Ids of the present session; those in [ready] have been OPENED. */
    private val open = HashMap<ServiceClient<*, *>, Int>()
    private val ready = HashSet<Int>()

    /** Never used twice: numbers are not those of one service. */
    private var next = 0
    private var isOver = false

    suspend fun response(client: ServiceClient<*, *>, payload: ByteArray, timeout: Duration): ByteArray {
        val call = Call(client, payload, TimeSource.Monotonic.markNow() + timeout)
        begin(call)
        try {
            return withTimeoutOrNull(timeout) { call.response.await() } ?: throw late(call, timeout)
        } finally {
            synchronized(this) { calls -= call }
        }
    }

    @Synchronized
    private fun late(call: Call, timeout: Duration): ServiceException {
        val service = call.client.service
        if (call.number == null) return ServiceException.linkDown(service, "there was no connection for $timeout")
        return ServiceException(ServiceException.Reason.TIMEOUT, "$service: no answer within $timeout")
    }

    @Synchronized
    private fun begin(call: Call) {
        if (isOver) return call.fail(ended(call))
        if (call.client.isClosed) return call.fail(refused(call.client, "the app has closed the client"))
        calls += call
        changes.trySend(Unit)
    }

    @Synchronized
    fun close(client: ServiceClient<*, *>) {
        client.isClosed = true
        fail(client) { refused(client, "the app has closed the client") }
        changes.trySend(Unit)
    }

    /** Ends all calls, with the streamer. */
    @Synchronized
    fun end() {
        isOver = true
        calls.forEach { it.fail(ended(it)) }
        calls.clear()
    }

    private fun fail(client: ServiceClient<*, *>, error: () -> ServiceException) {
        val failed = calls.filter { it.client == client }
        calls -= failed.toSet()
        failed.forEach { it.fail(error()) }
    }

    override suspend fun serve(lanes: OpeningLanes?) {
        try {
            while (true) {
                if (lanes == null) refuseAll() else serveOnce(lanes)
                changes.receive()
            }
        } finally {
            endSession()
        }
    }

    private suspend fun serveOnce(lanes: OpeningLanes) {
        for (id in takeClosed()) lanes.close(id)
        for (client in unopened()) {
            val id = lanes.nextId()
            synchronized(this) { open[client] = id }
            lanes.open(client.open(id))
        }
        while (true) {
            val call = takeSendable() ?: break
            val remaining = (-call.due.elapsedNow()).inWholeNanoseconds
            lanes.request(call.id, checkNotNull(call.number), call.payload, remaining.coerceAtLeast(1))
        }
    }

    @Synchronized
    private fun takeClosed(): List<Int> {
        val ids = open.filter { (client, id) -> client.isClosed && id in ready }.values.toList()
        open.values.removeAll(ids.toSet())
        ready -= ids.toSet()
        return ids
    }

    @Synchronized
    private fun unopened(): List<ServiceClient<*, *>> =
        calls.map { it.client }.distinct().filter { it !in open }

    @Synchronized
    private fun takeSendable(): Call? {
        val call = calls.firstOrNull { it.number == null && open[it.client] in ready } ?: return null
        call.id = open.getValue(call.client)
        call.number = next++
        return call
    }

    @Synchronized
    private fun refuseAll() {
        calls.map { it.client }.distinct().forEach { client ->
            fail(client) { refused(client, "the receiver serves no apps: $WHICH_DOES") }
        }
    }

    /** A request that was sent has no answer any more; others wait for the next session. */
    @Synchronized
    private fun endSession() {
        open.clear()
        ready.clear()
        val lost = calls.filter { it.number != null }
        calls -= lost.toSet()
        lost.forEach { it.fail(ServiceException.linkDown(it.client.service, "the connection was lost")) }
    }

    @Synchronized
    override fun opened(answer: Opened) {
        if (answer.id !in open.values) return
        if (!answer.isOpen) return end(answer.id, answer.reason.orEmpty())
        ready += answer.id
        changes.trySend(Unit)
    }

    @Synchronized
    override fun closed(end: Closed): Unit = end(end.id, end.reason)

    private fun end(id: Int, why: String) {
        val client = open.entries.firstOrNull { it.value == id }?.key ?: return
        open -= client
        ready -= id
        fail(client) { refused(client, why) }
    }

    @Synchronized
    override fun take(frame: Frame, left: () -> Unit): Boolean {
        val header = frame.header
        if (header.channel !in ready) return false
        val call = calls.firstOrNull { it.id == header.channel && it.number == header.sequence } ?: return false
        calls -= call
        if (frame.kind == FrameKind.RESPONSE) {
            call.response.complete(frame.body)
        } else {
            call.fail(ServiceException.of(call.client.service, ControlJson.decode<Failure>(frame.body)))
        }
        left()
        return true
    }

    override fun counts(): Map<String, Status.OpeningCounts> = emptyMap()

    private fun refused(client: ServiceClient<*, *>, why: String) =
        ServiceException(ServiceException.Reason.REFUSED, printable("${client.service}: $why"))

    private fun ended(call: Call) = ServiceException.linkDown(call.client.service, "the streamer has ended")
}
