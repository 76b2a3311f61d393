package dev.ml2sensors.unity

import dev.ml2sensors.ros.Keep
import dev.ml2sensors.ros.Received
import dev.ml2sensors.session.Receiver
import dev.ml2sensors.source.Headset
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.stream.Ml2Streamer
import dev.ml2sensors.stream.StreamerState
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable
import dev.ml2sensors.transport.TransportSecurity
import kotlinx.coroutines.flow.Flow
import kotlinx.coroutines.flow.combine
import kotlinx.coroutines.flow.first
import java.nio.ByteBuffer

/** One run of the streamer, from a start to its stop. Thread-safe. */
internal class UnityRun(headset: Headset, receiver: Receiver, security: TransportSecurity, val request: Request) :
    UnityInboxes.Topics {
    /** The arguments of [Ml2Unity.start]. */
    class Request(val receiver: String, val defaults: Map<String, StreamValues>, val isInsecure: Boolean)

    val streamer = Ml2Streamer(headset, receiver, security, request.defaults)

    /** The streams of the receiver's configuration and of the defaults. */
    val wanted: List<StreamSpec>
        get() = (request.defaults.keys + streamer.streams.value.keys).mapNotNull(StreamTable::byId)

    /** Streams until stopped, and calls [changed] whenever the status changes. */
    suspend fun run(changed: () -> Unit) {
        streamer.start()
        combine(streamer.state, streamer.streams, ::Pair).first { (state, _) ->
            changed()
            state is StreamerState.Ended
        }
    }

    suspend fun stop() {
        streamer.stop()
    }

    fun status(): UnityStatus = UnityStatus(streamer.status(request.receiver), request.isInsecure)

    override fun messages(
        topic: String,
        type: String,
        keep: Keep,
        maxHz: Double?,
        hash: String?,
    ): Flow<Received<ByteBuffer>> = streamer.subscribe(topic, type, keep, maxHz, hash)
}
