package dev.ml2sensors.unity

import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.stream.Ml2Streamer
import dev.ml2sensors.stream.StreamState
import dev.ml2sensors.stream.StreamerState
import dev.ml2sensors.wire.Status
import kotlinx.serialization.Serializable

/** What [Ml2Unity.status] says, as JSON. */
@Serializable
internal class UnityStatus(
    val state: String,
    val receiver: String,
    val reason: String,
    val streams: Map<String, Stream> = emptyMap(),
    val channels: Map<String, Status.ChannelCounts> = emptyMap(),
    val clock: Status.Clock? = null,
) {
    @Serializable
    class Stream(val state: String, val reason: String = "", val values: StreamValues? = null)

    companion object {
        /** While [streamer] looks for the receiver that the user named [receiver]; null for the only one there is. */
        fun of(streamer: Ml2Streamer, receiver: String): UnityStatus {
            val state = streamer.state.value
            return UnityStatus(
                state.word,
                (state as? StreamerState.Connected)?.receiverName ?: receiver,
                state.reason,
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
