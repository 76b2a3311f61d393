package dev.ml2sensors.simulator

import com.github.ajalt.clikt.core.UsageError
import dev.ml2sensors.message.ServiceType
import dev.ml2sensors.message.SetBool
import dev.ml2sensors.message.Trigger
import dev.ml2sensors.ros.ServiceClient
import dev.ml2sensors.ros.ServiceException
import dev.ml2sensors.ros.ServiceServer
import dev.ml2sensors.stream.Ml2Streamer
import kotlinx.coroutines.channels.Channel
import kotlinx.coroutines.channels.Channel.Factory.UNLIMITED
import kotlinx.coroutines.channels.consumeEach
import kotlinx.coroutines.coroutineScope
import kotlinx.coroutines.launch
import kotlinx.serialization.KSerializer
import kotlinx.serialization.json.Json
import java.util.concurrent.atomic.AtomicInteger
import kotlin.concurrent.thread
import kotlin.time.Duration.Companion.seconds

/** A type of services that this program has classes of. */
private class KnownType<Q, A>(
    val type: ServiceType<Q, A>,
    private val request: KSerializer<Q>,
    private val response: KSerializer<A>,
    private val answer: (String) -> A,
) {
    fun offer(streamer: Ml2Streamer, service: String, log: (String) -> Unit): ServiceServer {
        val requests = AtomicInteger()
        return streamer.service(service, type) {
            val text = "request ${requests.getAndIncrement()}"
            log("$service $text ${Json.encodeToString(request, it)}")
            answer(text)
        }
    }

    suspend fun call(client: ServiceClient<Q, A>, seconds: Double, json: String): String =
        Json.encodeToString(response, client.call(Json.decodeFromString(request, json), seconds.seconds))

    fun caller(streamer: Ml2Streamer, service: String): suspend (Double, String) -> String {
        val client = streamer.client(service, type)
        return { seconds, json -> call(client, seconds, json) }
    }
}

private val KNOWN: Map<String, KnownType<*, *>> = listOf(
    KnownType(SetBool, SetBool.Request.serializer(), SetBool.Response.serializer()) { SetBool.Response(true, it) },
    KnownType(Trigger, Trigger.Request.serializer(), Trigger.Response.serializer()) { Trigger.Response(true, it) },
).associateBy { it.type.name }

private fun known(option: String, type: String) =
    KNOWN[type] ?: throw UsageError("$option: expected one of ${KNOWN.keys.joinToString()}, found '$type'")

/** The option `--call`: a service of ROS that is called by lines of standard input. */
internal class CalledService(val service: String, type: String) {
    private val type = known("--call", type)

    /** @throws UsageError if the service has no name of ROS. */
    fun caller(streamer: Ml2Streamer): suspend (Double, String) -> String = try {
        type.caller(streamer, service)
    } catch (mistake: IllegalArgumentException) {
        throw UsageError("--call: ${mistake.message}")
    }
}

/** The option `--offer`: a service for ROS, which answers each request with its number. */
internal class OfferedService(private val service: String, type: String) {
    private val type = known("--offer", type)

    /**
     * Logs the requests, and whether ROS has the service, until the streamer ends.
     *
     * @throws UsageError if the service has no name of ROS.
     */
    fun logger(streamer: Ml2Streamer, log: (String) -> Unit): suspend () -> Unit {
        val server = try {
            type.offer(streamer, service, log)
        } catch (mistake: IllegalArgumentException) {
            throw UsageError("--offer: ${mistake.message}")
        }
        return {
            server.state.collect {
                if (it is ServiceServer.State.Offered) log("$service is offered as ${it.name}")
                if (it is ServiceServer.State.Refused) log("not offered: $service: ${it.reason}")
            }
        }
    }
}

/**
 * Returns what calls [services] as the lines `SERVICE SECONDS JSON` of standard input say, all at the same time: logs the
 * service, the number of the line, and the response as JSON or the reason why there is none within so many seconds.
 */
internal fun callsAsRead(
    services: List<CalledService>,
    streamer: Ml2Streamer,
    log: (String) -> Unit,
): suspend () -> Unit {
    val callers = services.associate { it.service to it.caller(streamer) }
    return {
        val lines = Channel<String>(UNLIMITED)
        if (callers.isNotEmpty()) thread(isDaemon = true) { generateSequence(::readlnOrNull).forEach(lines::trySend) }
        var number = 0
        coroutineScope {
            lines.consumeEach { line ->
                val words = line.split(' ', limit = 3)
                val prefix = "${words.first()} ${number++}"
                launch { log("$prefix ${callers.outcome(words)}") }
            }
        }
    }
}

private suspend fun Map<String, suspend (Double, String) -> String>.outcome(words: List<String>): String {
    val call = get(words.first())
    val seconds = words.getOrNull(1)?.toDoubleOrNull()
    if (call == null || seconds == null || words.size < 3) {
        return "expected SERVICE SECONDS JSON, of the services ${keys.joinToString()}"
    }
    return try {
        call(seconds, words[2])
    } catch (failed: ServiceException) {
        "${failed.reason}: ${failed.message}"
    } catch (mistake: IllegalArgumentException) { // SerializationException is one
        "${mistake.message}"
    }
}
