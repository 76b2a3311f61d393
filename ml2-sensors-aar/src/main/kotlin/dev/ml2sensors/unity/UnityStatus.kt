package dev.ml2sensors.unity

import dev.ml2sensors.pairing.PairedReceiver
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.stream.Ml2Streamer
import dev.ml2sensors.stream.StreamState
import dev.ml2sensors.stream.StreamerState
import dev.ml2sensors.wire.Status
import kotlinx.serialization.Serializable

/** What [Ml2Unity.status] says, as JSON. */
@Serializable
internal data class UnityStatus(
    val state: String,
    val receiver: String,
    val reason: String,
    val insecure: Boolean = false,
    val streams: Map<String, Stream> = emptyMap(),
    val channels: Map<String, Status.ChannelCounts> = emptyMap(),
    val clock: Status.Clock? = null,
    val pairing: Pairing = Pairing(),
) {
    @Serializable
    class Stream(val state: String, val reason: String = "", val values: StreamValues? = null)

    @Serializable
    class Receiver(val name: String, val fingerprint: String, val address: String) {
        constructor(paired: PairedReceiver) :
            this(paired.name, paired.fingerprint.hex, "${paired.address}")
    }

    /** What became of the last pairing, of which there were [number], and with whom this app is paired. */
    @Serializable
    data class Pairing(
        val number: Int = 0,
        val state: String = "none",
        val reason: String = "",
        val receivers: List<Receiver> = emptyList(),
    )

    companion object {
        /** Of a [streamer] that does what was asked for by [request]. */
        fun of(streamer: Ml2Streamer, request: UnityRun.Request): UnityStatus {
            val state = streamer.state.value
            return UnityStatus(
                state.word,
                (state as? StreamerState.Connected)?.receiverName ?: request.receiver,
                state.reason,
                request.isInsecure,
                streamer.streams.value.mapValues { (_, it) -> it.toStatus() },
                streamer.counts(),
                streamer.clock(),
            )
        }

        private val StreamerState.word
            get() = when (this) {
                is StreamerState.Connecting -> "connecting"
                is StreamerState.Connected -> "connected"
                is StreamerState.Ended -> "ended"
            }

        private val StreamerState.reason
            get() = when (this) {
                is StreamerState.Connecting -> reason.orEmpty()
                is StreamerState.Connected -> ""
                is StreamerState.Ended -> reason
            }

        private fun StreamState.toStatus() = when (this) {
            is StreamState.Accepted -> Stream("accepted", adjusted.orEmpty(), values)
            is StreamState.Refused -> Stream("refused", reason)
            is StreamState.Failed -> Stream("failed", reason)
        }
    }
}

/** One row of [Ml2Unity.permissionsNeeded]. */
@Serializable
internal class NeededPermission(val permission: String, val reason: String, val streams: List<String>)
