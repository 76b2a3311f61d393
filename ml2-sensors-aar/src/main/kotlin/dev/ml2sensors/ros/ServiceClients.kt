package dev.ml2sensors.ros

import dev.ml2sensors.cdr.Cdr
import dev.ml2sensors.message.ServiceType
import dev.ml2sensors.session.OpeningLanes
import dev.ml2sensors.wire.ControlJson
import dev.ml2sensors.wire.Failure
import dev.ml2sensors.wire.Frame
import dev.ml2sensors.wire.FrameKind
import dev.ml2sensors.wire.Open
import dev.ml2sensors.wire.printable
import kotlinx.coroutines.CompletableDeferred
import kotlinx.coroutines.withTimeoutOrNull
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
    internal val named: NamedService,
    private val encode: (Q) -> ByteArray,
    private val decode: (ByteArray) -> A,
) : AutoCloseable {
    internal val service get() = named.name

    /** Used under the lock of [clients]. */
    internal var isClosed = false

    /**
     * Returns the response to [request]. Each call ends with the response or one exception, within [timeout]. Without a
     * connection it waits for one that long.
     *
     * @throws ServiceException if there is no response.
     * @throws IllegalArgumentException if [timeout] is not above zero, or the request has no CDR.
     */
    public suspend fun call(request: Q, timeout: Duration): A {
        require(timeout.isPositive()) { "timeout: expected more than 0, found $timeout" }
        val payload = encode(request)
        named.book.begin()
        var failure: String? = Failure.CANCELLED
        try {
            return response(payload, timeout).also { failure = null }
        } catch (e: ServiceException) {
            failure = e.reason.code ?: Failure.OTHER
            throw e
        } finally {
            named.book.end(failure)
        }
    }

    private suspend fun response(payload: ByteArray, timeout: Duration): A {
        if (payload.size > FrameKind.REQUEST.maxLength) {
            val found = "a request of ${payload.size} bytes, expected at most ${FrameKind.REQUEST.maxLength}"
            throw ServiceException(ServiceException.Reason.TOO_LARGE, "$service: $found")
        }
        val response = clients.response(this, payload, timeout)
        return try {
            decode(response)
        } catch (e: IllegalArgumentException) { // SerializationException is one
            throw ServiceException(ServiceException.Reason.MALFORMED, "$service: ${e.message}")
        }
    }

    /** Ends the client. Calls that are under way fail, as do later ones. */
    override fun close(): Unit = clients.close(this)
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
internal class ServiceClients : OpenServices<ServiceClient<*, *>>({ it.named }) {
    /** In the order of the calls: those that were not sent, and those that were. */
    private val calls = LinkedHashSet<Call>()

    /** Never used twice: numbers are not those of one service. */
    private var next = 0
    private var isOver = false

    /** As [dev.ml2sensors.stream.Ml2Streamer.client]. */
    fun <Q, A> client(service: String, type: ServiceType<Q, A>): ServiceClient<Q, A> = ServiceClient(
        this,
        NamedService(Open.CLIENT, service, type.name, type.layout),
        { Cdr.encodeToByteArray(type.request, it) },
        { Cdr.decode(type.response, ByteBuffer.wrap(it), allowsTail = true) },
    )

    /** As the other one, for a [type] without classes: requests and responses are their CDR. */
    fun client(service: String, type: String): ServiceClient<ByteArray, ByteArray> =
        ServiceClient(this, NamedService(Open.CLIENT, service, type, layout = null), { it }, { it })

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
        if (call.client.isClosed) return call.fail(refusal(call.client, "the app has closed the client"))
        calls += call
        change()
    }

    @Synchronized
    fun close(client: ServiceClient<*, *>) {
        client.isClosed = true
        fail(client) { refusal(client, "the app has closed the client") }
        change()
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

    override fun wanted() = calls.map { it.client }.distinct()

    override fun isClosed(service: ServiceClient<*, *>) = service.isClosed

    override fun refused(service: ServiceClient<*, *>, why: String): Unit =
        fail(service) { refusal(service, why) }

    override suspend fun send(lanes: OpeningLanes) {
        while (true) {
            val call = takeSendable() ?: break
            val remaining = (-call.due.elapsedNow()).inWholeNanoseconds
            lanes.request(call.id, checkNotNull(call.number), call.payload, remaining.coerceAtLeast(1))
        }
    }

    @Synchronized
    private fun takeSendable(): Call? {
        val call = calls.firstOrNull { it.number == null && readyId(it.client) != null } ?: return null
        call.id = checkNotNull(readyId(call.client))
        call.number = next++
        return call
    }

    /** A request that was sent has no answer any more; others wait for the next session. */
    override fun sessionEnds() {
        val lost = calls.filter { it.number != null }
        calls -= lost.toSet()
        lost.forEach { it.fail(ServiceException.linkDown(it.client.service, "the connection was lost")) }
    }

    @Synchronized
    override fun take(frame: Frame, left: () -> Unit): Boolean {
        val header = frame.header
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

    private fun refusal(client: ServiceClient<*, *>, why: String) =
        ServiceException(ServiceException.Reason.REFUSED, printable("${client.service}: $why"))

    private fun ended(call: Call) = ServiceException.linkDown(call.client.service, "the streamer has ended")
}
