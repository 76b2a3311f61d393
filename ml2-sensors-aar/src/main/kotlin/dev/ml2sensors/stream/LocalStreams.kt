package dev.ml2sensors.stream

import dev.ml2sensors.source.Answer
import dev.ml2sensors.source.Headset
import dev.ml2sensors.source.RefusedException
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.source.acceptedValues
import dev.ml2sensors.source.orDefaultsOf
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable
import kotlinx.coroutines.CoroutineScope
import kotlinx.coroutines.Job
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
    private val running = HashMap<StreamSpec, Job>()

    /** A stream that is wanted, and what the headset answers. */
    class Asked(val spec: StreamSpec, val values: StreamValues, val answer: Answer)

    /** Asks for the streams [wanted], by id; missing values are the stream's defaults. An unknown stream is null. */
    fun ask(wanted: Map<String, StreamValues>): Map<String, Asked?> = wanted.mapValues { (id, values) ->
        StreamTable.byId(id)?.let { spec ->
            val requested = values.orDefaultsOf(spec)
            Asked(spec, requested, headset.negotiate(spec, requested))
        }
    }

    /** Runs the streams [asked]; returns their states. */
    fun begin(asked: Map<String, Asked?>): Map<String, StreamState> = asked.mapValues { (id, stream) ->
        if (stream == null) return@mapValues StreamState.Refused("this headset has no stream $id")
        running[stream.spec] = scope.launch { run(stream.spec, stream.values, stream.answer) }
        stream.answer.toState()
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

    /** Returns the streams that run, for the caller to end. */
    fun take(): Map<StreamSpec, Job> = running.toMap().also { running.clear() }
}
