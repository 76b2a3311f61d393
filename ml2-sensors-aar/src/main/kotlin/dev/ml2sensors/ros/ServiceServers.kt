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
import kotlinx.coroutines.CoroutineScope
import kotlinx.coroutines.CoroutineStart
import kotlinx.coroutines.DelicateCoroutinesApi
import kotlinx.coroutines.Dispatchers
import kotlinx.coroutines.ExperimentalCoroutinesApi
import kotlinx.coroutines.SupervisorJob
import kotlinx.coroutines.async
import kotlinx.coroutines.cancel
import kotlinx.coroutines.flow.MutableStateFlow
import kotlinx.coroutines.flow.StateFlow
import kotlinx.coroutines.flow.asStateFlow
import kotlinx.coroutines.launch
import kotlinx.coroutines.withTimeoutOrNull
import java.nio.ByteBuffer
import kotlin.time.Duration.Companion.nanoseconds

/**
 * A service of the app, which nodes of ROS call until it is closed. Thread-safe. It uses one of the 64 openings of an app.
 */
public class ServiceServer internal constructor(
    private val servers: ServiceServers,
    internal val named: NamedService,
    /** Returns the response to a request, both as CDR. */
    internal val respond: suspend (ByteArray) -> ByteArray,
) : AutoCloseable {
    private val mutableState = MutableStateFlow<State>(State.Waiting)

    /** The current state of the service in ROS. */
    public val state: StateFlow<State> = mutableState.asStateFlow()

    internal fun become(state: State) {
        mutableState.value = state
    }

    /** Ends the service. Requests that are under way are not answered by the app any more. */
    override fun close(): Unit = servers.close(this)

    /** The state of a service. */
    public sealed interface State {
        /** There is no session, or the receiver has not answered yet. */
        public data object Waiting : State

        /** Nodes of ROS can call the service, by its full [name]. */
        public data class Offered(val name: String) : State

        /** ROS does not have the service in this session, which [reason] explains. The next session asks again. */
        public data class Refused(val reason: String) : State
    }
}

/** The services that an app offers, over all sessions of its streamer. Thread-safe. */
internal class ServiceServers : OpenServices<ServiceServer>({ it.named }) {
    /** The app's code may block: it has threads of its own, so that it delays no sensor. */
    private val handlers = CoroutineScope(SupervisorJob() + Dispatchers.IO.limitedParallelism(MOST_REQUESTS))
    private val offered = LinkedHashSet<ServiceServer>()

    /** The services that are not asked for again in the present session. */
    private val refused = HashSet<ServiceServer>()
    private var answer: ((ServiceServer, Frame) -> Unit)? = null
    private var isOver = false

    fun <Q, A> offer(name: String, type: ServiceType<Q, A>, answer: suspend (Q) -> A): ServiceServer = offer(
        NamedService(Open.SERVICE, name, type.name, type.layout),
    ) { request ->
        val asked = try {
            Cdr.decode(type.request, ByteBuffer.wrap(request), allowsTail = true)
        } catch (e: IllegalArgumentException) { // SerializationException is one
            throw UnanswerableException(Failure.MALFORMED, "${e.message}", e)
        }
        Cdr.encodeToByteArray(type.response, answer(asked))
    }

    /** As the other one, for a [type] without classes: requests and responses are their CDR. */
    fun offer(name: String, type: String, answer: suspend (ByteArray) -> ByteArray): ServiceServer =
        offer(NamedService(Open.SERVICE, name, type, layout = null), answer)

    private fun offer(named: NamedService, respond: suspend (ByteArray) -> ByteArray): ServiceServer {
        val server = ServiceServer(this, named, respond)
        synchronized(this) {
            if (isOver) server.become(ENDED) else offered += server
        }
        change()
        return server
    }

    @Synchronized
    fun close(server: ServiceServer) {
        if (!offered.remove(server)) return
        server.become(ServiceServer.State.Refused("the app has closed the service"))
        change()
    }

    /** Ends all services, with the streamer. */
    @Synchronized
    fun end() {
        isOver = true
        handlers.cancel()
        offered.forEach { it.become(ENDED) }
        offered.clear()
    }

    override fun wanted() = offered.filter { it !in refused }

    override fun isClosed(service: ServiceServer) = service !in offered

    override fun opened(service: ServiceServer, name: String) {
        if (service in offered) service.become(ServiceServer.State.Offered(name))
    }

    override fun refused(service: ServiceServer, why: String) {
        refused += service
        if (service in offered) service.become(ServiceServer.State.Refused(printable(why)))
    }

    /** Each request that was counted is answered or counted as lost, so its coroutine begins also when cancelled. */
    @OptIn(DelicateCoroutinesApi::class, ExperimentalCoroutinesApi::class)
    override fun sessionBegins(session: CoroutineScope, lanes: OpeningLanes) {
        answer = { server, request ->
            session.launch(start = CoroutineStart.ATOMIC) {
                var failure: String? = Failure.LINK_DOWN
                try {
                    failure = lanes.answer(server, request)?.code
                } finally {
                    server.named.book.end(failure)
                }
            }
        }
    }

    override fun sessionEnds() {
        answer = null
        refused.clear()
        if (!isOver) offered.forEach { it.become(ServiceServer.State.Waiting) }
    }

    /**
     * Lets the app answer, no longer than the request is waited for, and returns the failure that was sent. What does not
     * end then is left behind.
     */
    private suspend fun OpeningLanes.answer(server: ServiceServer, request: Frame): Failure? {
        val (id, number) = request.header.channel to request.header.sequence
        val answering = handlers.async { runCatching { server.respond(request.body) } }
        val outcome = try {
            withTimeoutOrNull(request.header.captureNanos.nanoseconds) { answering.await() }
        } finally {
            answering.cancel()
        }
        val failure = failure(outcome)
        if (failure == null) {
            answer(id, number, FrameKind.RESPONSE, checkNotNull(outcome).getOrThrow())
        } else {
            answer(id, number, FrameKind.FAILURE, ControlJson.encode(failure))
        }
        return failure
    }

    private fun failure(outcome: Result<ByteArray>?): Failure? {
        if (outcome == null) return Failure(Failure.TIMEOUT, "the app did not answer in time")
        val most = FrameKind.RESPONSE.maxLength
        return outcome.fold({ response ->
            val found = "a response of ${response.size} bytes, expected at most $most"
            Failure(Failure.TOO_LARGE, found).takeIf { response.size > most }
        }, {
            val code = (it as? UnanswerableException)?.code ?: Failure.REFUSED
            val why = if (it is UnanswerableException) "${it.message}" else "${it.javaClass.simpleName}: ${it.message}"
            Failure(code, printable(why.take(MOST_CHARACTERS)))
        })
    }

    @Synchronized
    override fun take(frame: Frame, left: () -> Unit): Boolean {
        val server = find(frame.header.channel)?.takeIf { it in offered } ?: return false
        server.named.book.begin()
        answer?.invoke(server, frame)
        left()
        return true
    }

    /** The request has the failure [code]. */
    private class UnanswerableException(val code: String, message: String, cause: Throwable) :
        Exception(message, cause)

    private companion object {
        const val MOST_REQUESTS = 64
        const val MOST_CHARACTERS = 500
        val ENDED = ServiceServer.State.Refused("the streamer has ended")
    }
}
