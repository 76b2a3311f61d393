package dev.ml2sensors.app.status

import dev.ml2sensors.stream.StreamerStatus
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable
import kotlinx.serialization.SerialName
import kotlinx.serialization.Serializable

/**
 * The status of a stream that the receiver requested.
 *
 * @property state `running`, `waiting`, `refused` or `failed`.
 * @property reason why; may be empty.
 * @property produced the number of messages of its first topic.
 * @property dropped the number of dropped messages of all its topics.
 * @property isPaused true while the stream is paused because the headset is hot.
 */
@Serializable
internal data class StreamStatus(
    val id: String,
    val state: String,
    val reason: String,
    val produced: Long,
    val dropped: Long,
    @SerialName("resting") val isPaused: Boolean,
)

/** Returns the status of each stream, in the order of the stream table. [paused] holds the ids of paused streams. */
internal fun StreamerStatus.byStream(paused: Set<String>): List<StreamStatus> = StreamTable.all.mapNotNull { spec ->
    streams[spec.id]?.let { stream ->
        val counts = channels.filterKeys { it in spec }.values
        val first = channels[spec.topics.firstOrNull()?.name] ?: counts.firstOrNull()
        val dropped = counts.sumOf { it.dropped.values.sum() }
        StreamStatus(
            spec.id,
            stream.state,
            stream.reason.take(TEXT_LIMIT),
            first?.produced ?: 0,
            dropped,
            spec.id in paused,
        )
    }
}

private operator fun StreamSpec.contains(topic: String) =
    if (topics.isEmpty()) topic.startsWith("$id/") else topics.any { it.name == topic }
