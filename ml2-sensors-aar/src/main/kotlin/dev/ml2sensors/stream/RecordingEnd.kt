package dev.ml2sensors.stream

import dev.ml2sensors.table.StreamSpec
import kotlinx.coroutines.CompletableDeferred

/**
 * Finds the end of a recording: all its streams that are accepted or have begun have ended. So a paused stream keeps
 * its rest. Used under one lock, except [await].
 */
internal class RecordingEnd {
    private val ended = HashSet<StreamSpec>()

    /** The streams that have begun and not ended, also while they are paused. */
    private val unfinished = HashSet<StreamSpec>()
    private val isOver = CompletableDeferred<Unit>()

    fun begin(stream: StreamSpec) {
        unfinished += stream
    }

    fun end(stream: StreamSpec, accepted: Set<StreamSpec>) {
        ended += stream
        unfinished -= stream
        if (unfinished.isEmpty() && ended.containsAll(accepted)) isOver.complete(Unit)
    }

    suspend fun await(): Unit = isOver.await()
}
