package dev.ml2sensors.stream

import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable

/** The table's frames as one receiver names them, which puts [prefix] before each to tell several headsets apart. */
internal data class FrameIds(private val prefix: String = "") {
    val world: String get() = prefix + StreamTable.WORLD_FRAME

    val head: String get() = prefix + StreamTable.HEAD_FRAME

    /** Of the messages of [stream]; empty for those that the app makes. */
    fun of(stream: StreamSpec): String = if (stream.frameId.isEmpty()) "" else prefix + stream.frameId

    /** The REP-103 frame beside that, of a [stream] with poses. */
    fun bodyOf(stream: StreamSpec): String = prefix + checkNotNull(stream.bodyFrameId) { "$stream has no pose" }
}
