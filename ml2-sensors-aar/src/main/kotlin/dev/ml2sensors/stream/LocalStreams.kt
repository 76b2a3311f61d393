package dev.ml2sensors.stream

import dev.ml2sensors.source.Answer
import dev.ml2sensors.source.Headset
import dev.ml2sensors.source.RefusedException
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.source.acceptedValues
import dev.ml2sensors.source.defaultValues
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable
import kotlinx.coroutines.CoroutineScope
import kotlinx.coroutines.Job
import kotlinx.coroutines.cancelAndJoin
import kotlinx.coroutines.launch

/**
 * Runs streams without a receiver, for readers on the headset itself. Not thread-safe.
 *
 * @param onState receives the state of a stream when it changes.
 */
internal class LocalStreams(
    private val headset: Headset,
    private val scope: CoroutineScope,
    private val onState: suspend (StreamSpec, StreamState) -> Unit,
) {
    private val running = ArrayList<Job>()

    /** Runs the streams [wanted], by id; empty values mean the stream's defaults. */
    fun begin(wanted: Map<String, StreamValues>): Map<String, StreamState> = wanted.mapValues { (id, values) ->
        val spec = StreamTable.byId(id) ?: return@mapValues StreamState.Refused("this headset has no stream $id")
        val requested = values.takeIf { StreamValues() != it } ?: spec.defaultValues()
        val answer = headset.negotiate(spec, requested)
        running += scope.launch { run(spec, requested, answer) }
        answer.toState()
    }

    /** Runs one stream, and negotiates again before each attempt: it may be accepted by then. */
    private suspend fun run(spec: StreamSpec, requested: StreamValues, first: Answer): Nothing {
        var next: Answer? = first
        var answer = first
        StreamSupervisor.of(spec, headset) { onState(spec, it ?: answer.toState()) }.run({
            answer = next ?: headset.negotiate(spec, requested)
            next = null
            (answer as? Answer.Refused)?.let { throw RefusedException(spec, it) }
            headset.samples(spec, checkNotNull(answer.acceptedValues))
        }) { it.collect {} }
    }

    /** Returns when all have stopped. */
    suspend fun end() {
        running.forEach { it.cancelAndJoin() }
        running.clear()
    }
}
