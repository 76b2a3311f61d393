package dev.ml2sensors.stream

import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.wire.Status
import kotlinx.serialization.Serializable

/**
 * All that is known of a streamer at one instant, for people and as JSON.
 *
 * @property state `connecting`, `connected` or `ended`.
 * @property receiver by its name, empty while it is not known.
 * @property reason why it is not connected; may be empty.
 * @property streams what became of each stream the receiver asked for, by id.
 * @property channels the books by topic.
 * @property clock how well ROS time is known; null before the first exchange with a receiver.
 */
@Serializable
public class StreamerStatus(
    public val state: String,
    public val receiver: String,
    public val reason: String,
    public val streams: Map<String, Stream> = emptyMap(),
    public val channels: Map<String, Status.ChannelCounts> = emptyMap(),
    public val clock: Status.Clock? = null,
) {
    /**
     * What became of one stream.
     *
     * @property state `accepted`, `waiting` (opened again until it runs), `refused` or `failed`.
     * @property reason for the latter three, or why [values] are not those asked for; may be empty.
     * @property values that it runs with; null where it does not.
     * @property permission the Android permission that it lacks; null when that is not what is missing.
     */
    @Serializable
    public class Stream(
        public val state: String,
        public val reason: String = "",
        public val values: StreamValues? = null,
        public val permission: String? = null,
    )

    internal companion object {
        /** [receiver] is what it is called as long as it does not tell its name. */
        fun of(streamer: Ml2Streamer, receiver: String): StreamerStatus {
            val state = streamer.state.value
            return StreamerStatus(
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
            is StreamState.Waiting -> Stream("waiting", reason, permission = permission)
            is StreamState.Refused -> Stream("refused", reason, permission = permission)
            is StreamState.Failed -> Stream("failed", reason)
        }
    }
}
