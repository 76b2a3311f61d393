package dev.ml2sensors.stream

import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.wire.Status
import kotlinx.serialization.Serializable

/**
 * The status of a streamer at one time, for people and as JSON.
 *
 * @property state `connecting`, `connected` or `ended`.
 * @property receiver its name, empty while unknown.
 * @property reason why it is not connected; may be empty.
 * @property streams the state of each stream that the receiver requested, by id.
 * @property channels the counters by topic.
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
     * The state of one stream.
     *
     * @property state `running`, `waiting` (opened again until it runs), `refused` or `failed`.
     * @property reason of the latter three, or why [values] differ from the requested ones; may be empty.
     * @property values that it runs with; null if it does not run.
     * @property permission the missing Android permission; null if that is not what is missing.
     */
    @Serializable
    public class Stream(
        public val state: String,
        public val reason: String = "",
        public val values: StreamValues? = null,
        public val permission: String? = null,
    )

    internal companion object {
        /** Returns the status; [receiver] names the receiver until its own name is known. */
        fun of(streamer: Ml2Streamer, receiver: String): StreamerStatus {
            val state = streamer.state.value
            return StreamerStatus(
                state.word,
                (state as? StreamerState.Connected)?.receiverName ?: receiver,
                state.reason,
                streamer.streams.value.mapValues { (id, it) -> it.toStatus(streamer.holds[id]) },
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

        private fun StreamState.toStatus(held: String?) = when (this) {
            is StreamState.Running ->
                if (held == null) Stream("running", adjusted.orEmpty(), values) else Stream("waiting", held)

            is StreamState.Waiting -> Stream("waiting", reason, permission = permission)

            is StreamState.Refused -> Stream("refused", reason, permission = permission)

            is StreamState.Failed -> Stream("failed", reason)
        }
    }
}

/** The state of a streamer. */
public sealed interface StreamerState {
    /** There is no session. [reason] says why the last one failed or ended; null before the first. */
    public data class Connecting(
        val reason: String?,
    ) : StreamerState

    /** There is a session with the receiver [receiverName]. */
    public data class Connected(
        val receiverName: String,
    ) : StreamerState

    /** The streamer has ended for this [reason]: it was stopped, a recording is over, or the library failed. */
    public data class Ended(
        val reason: String,
    ) : StreamerState
}
