package dev.ml2sensors.stream

import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable

/** The frame ids for one receiver, which puts [prefix] before those of the table to distinguish headsets. */
internal data class FrameIds(private val prefix: String = "") {
    val world: String get() = prefix + StreamTable.WORLD_FRAME

    val head: String get() = prefix + StreamTable.HEAD_FRAME

    /** Returns the frame id of a marker that is called [name]. */
    fun ofMarker(name: String): String = prefix + name

    /** Returns the frame id of messages of [stream]; empty for those of the app. */
    fun of(stream: StreamSpec): String = if (stream.frameId.isEmpty()) "" else prefix + stream.frameId

    /** Returns the REP-103 body frame of a [stream] with poses. */
    fun bodyOf(stream: StreamSpec): String = prefix + checkNotNull(stream.bodyFrameId) { "$stream has no pose" }
}
