package dev.ml2sensors.unity

import dev.ml2sensors.session.Receiver
import dev.ml2sensors.source.Headset
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.stream.Ml2Streamer
import dev.ml2sensors.stream.StreamerState
import dev.ml2sensors.stream.TopicPublisher
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable
import dev.ml2sensors.transport.TransportSecurity
import kotlinx.coroutines.flow.combine
import kotlinx.coroutines.flow.first
import java.util.concurrent.CopyOnWriteArrayList

/** One run of the streamer, from a start to its stop. Thread-safe. */
internal class UnityRun(headset: Headset, receiver: Receiver, security: TransportSecurity, val request: Request) {
    /** The arguments of [Ml2Unity.start]. */
    class Request(val receiver: String, val defaults: Map<String, StreamValues>, val isInsecure: Boolean)

    private val streamer = Ml2Streamer(headset, receiver, security, request.defaults)
    private val publishers = CopyOnWriteArrayList<TopicPublisher>()

    /** The streams of the receiver's configuration and of the defaults. */
    val wanted: List<StreamSpec>
        get() = (request.defaults.keys + streamer.streams.value.keys).mapNotNull(StreamTable::byId)

    /** Streams until stopped, and calls [changed] whenever the status changes. */
    suspend fun run(changed: () -> Unit) {
        streamer.start()
        combine(streamer.state, streamer.streams, ::Pair).first { (state, _) ->
            val isOver = state is StreamerState.Ended
            if (!isOver) changed()
            isOver
        }
    }

    suspend fun stop() {
        streamer.stop()
    }

    fun status(): UnityStatus = UnityStatus(streamer.status(request.receiver), request.isInsecure)

    /** Opens the publisher of [name]; publishers are numbered in the order of their first opening. */
    fun open(name: String, type: String) {
        publishers.addIfAbsent(streamer.publisher(name, type))
    }

    fun publisher(number: Int): TopicPublisher = publishers[number]

    fun stampNanos(captureNanos: Long): Long? = streamer.stampNanos(captureNanos)
}
