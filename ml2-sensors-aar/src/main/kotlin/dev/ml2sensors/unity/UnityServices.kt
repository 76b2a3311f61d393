package dev.ml2sensors.unity

import dev.ml2sensors.capture.LocalInbox
import dev.ml2sensors.capture.LocalOutbox
import dev.ml2sensors.ros.NamedService
import dev.ml2sensors.ros.ServiceClient
import dev.ml2sensors.ros.ServiceException
import dev.ml2sensors.ros.ServiceServer
import dev.ml2sensors.stream.Ml2Streamer
import dev.ml2sensors.wire.Open
import kotlinx.coroutines.CompletableDeferred
import kotlinx.coroutines.CoroutineScope
import kotlinx.coroutines.launch
import java.nio.ByteBuffer
import java.util.concurrent.ConcurrentHashMap
import java.util.concurrent.atomic.AtomicInteger
import kotlin.concurrent.thread
import kotlin.time.Duration.Companion.nanoseconds

/**
 * The services that a Unity app calls and offers, over starts and stops. Each has an outbox of the native library for what
 * C# sends, and an inbox for what C# gets. A response has the number of its request. Thread-safe.
 */
internal class UnityServices(private val scope: CoroutineScope) {
    private val services = HashMap<Int, UnityService>()
    private var streamer: Ml2Streamer? = null

    /**
     * Opens a client of a [service] of ROS. C# sends requests, whose time is the time-out in ns. It gets responses as CDR,
     * and failures as a byte and a text for people. The byte is 1 for the first of [ServiceException.Reason], and so on.
     *
     * @return the number of the outbox, by which the other functions know the service.
     * @throws IllegalArgumentException if ROS does not allow the name or the type.
     */
    fun call(
        service: String,
        type: String,
    ): Int = open(Open.CLIENT, service, type) { CalledService(service, type, scope) }

    /**
     * Offers a [service] to nodes of ROS. C# gets requests. It sends responses as CDR, and failures as a byte of 1 and a
     * text for people. Otherwise as [call].
     */
    fun offer(service: String, type: String): Int = open(Open.SERVICE, service, type) { OfferedService(service, type) }

    @Synchronized
    private fun open(kind: String, name: String, type: String, make: () -> UnityService): Int {
        NamedService(kind, name, type, layout = null)
        val service = make()
        services[service.outbox.number] = service
        streamer?.let(service::use)
        thread(isDaemon = true, name = "ml2s $name") { service.outbox.forEach(service::take) }
        return service.outbox.number
    }

    /** Returns the number of the inbox of a service. */
    @Synchronized
    fun inbox(service: Int): Int = services.getValue(service).inbox.number

    /** Returns why ROS does not have a service that is offered; empty if it does, and before it is known. */
    @Synchronized
    fun refusal(service: Int): String = services[service]?.refusal.orEmpty()

    /** Ends a service. Calls that are under way fail. */
    @Synchronized
    fun close(service: Int) {
        services.remove(service)?.close()
    }

    /** Calls and offers them through [next] from now on. */
    @Synchronized
    fun use(next: Ml2Streamer) {
        streamer = next
        services.values.forEach { it.use(next) }
    }

    @Synchronized
    fun close() {
        services.keys.toList().forEach(::close)
    }
}

private abstract class UnityService {
    val outbox = LocalOutbox(MOST_MESSAGES)
    val inbox = LocalInbox(MOST_MESSAGES)

    /** The reason for which ROS does not have the service; null if it has. */
    open val refusal: String? get() = null

    abstract fun use(streamer: Ml2Streamer)

    /** Takes what C# has sent. */
    abstract fun take(message: LocalOutbox.Message)

    /** Returns false if this is closed. */
    fun give(bytes: ByteArray, number: Int): Boolean = inbox.add(ByteBuffer.wrap(bytes), publishedNanos = 0, number)

    open fun close() {
        outbox.close()
        inbox.close()
    }

    private companion object {
        /** More than are under way. */
        const val MOST_MESSAGES = 100
    }
}

private class CalledService(private val name: String, private val type: String, private val scope: CoroutineScope) :
    UnityService() {
    @Volatile
    private var client: ServiceClient<ByteArray, ByteArray>? = null

    override fun use(streamer: Ml2Streamer) {
        client = streamer.clients.client(name, type)
    }

    override fun take(message: LocalOutbox.Message) {
        val (request, timeout, number) = Triple(message.copy(), message.nanos.nanoseconds, message.number)
        scope.launch {
            val answer = try {
                client?.call(request, timeout)
                    ?: failure(ServiceException.Reason.LINK_DOWN, "the streamer is not started")
            } catch (e: ServiceException) {
                failure(e.reason, e.message.orEmpty())
            }
            give(answer, number)
        }
    }

    private fun failure(reason: ServiceException.Reason, message: String): ByteArray =
        byteArrayOf((reason.ordinal + 1).toByte()) + message.encodeToByteArray()

    override fun close() {
        client?.close()
        super.close()
    }
}

private class OfferedService(private val name: String, private val type: String) : UnityService() {
    private val waiting = ConcurrentHashMap<Int, CompletableDeferred<ByteArray>>()
    private val last = AtomicInteger()

    @Volatile
    private var server: ServiceServer? = null

    override val refusal get() = (server?.state?.value as? ServiceServer.State.Refused)?.reason

    override fun use(streamer: Ml2Streamer) {
        server = streamer.servers.offer(name, type, ::respond)
    }

    private suspend fun respond(request: ByteArray): ByteArray {
        val number = last.incrementAndGet()
        val response = CompletableDeferred<ByteArray>()
        waiting[number] = response
        try {
            check(give(request, number)) { "the app has closed $name" }
            return response.await()
        } finally {
            waiting -= number
        }
    }

    override fun take(message: LocalOutbox.Message) {
        val response = waiting[message.number] ?: return // It is not waited for any more
        val bytes = message.copy()
        if (bytes[0] == 0.toByte()) {
            response.complete(bytes)
        } else {
            response.completeExceptionally(IllegalStateException(bytes.decodeToString(startIndex = 1)))
        }
    }

    override fun close() {
        server?.close()
        super.close()
    }
}

private fun LocalOutbox.Message.copy(): ByteArray = ByteArray(bytes.remaining()).also(bytes::get)
