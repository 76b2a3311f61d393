package dev.ml2sensors.app.status

import dev.ml2sensors.stream.StreamerStatus
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable
import kotlinx.serialization.Serializable

/**
 * What became of a stream that the receiver asked for.
 *
 * @property state `accepted`, `waiting`, `refused` or `failed`; [reason] may be empty.
 * @property produced messages of its first topic.
 * @property dropped messages of all its topics.
 * @property resting because the headset is hot.
 */
@Serializable
internal data class StreamStatus(
    val id: String,
    val state: String,
    val reason: String,
    val produced: Long,
    val dropped: Long,
    val resting: Boolean,
)

/** In the order of the stream table; those with the ids [resting] are. */
internal fun StreamerStatus.byStream(resting: Set<String>): List<StreamStatus> = StreamTable.all.mapNotNull { spec ->
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
            spec.id in resting,
        )
    }
}

private operator fun StreamSpec.contains(topic: String) =
    if (topics.isEmpty()) topic.startsWith("$id/") else topics.any { it.name == topic }
