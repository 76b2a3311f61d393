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
 * Streams that run without a receiver, for who reads their frames on the headset itself. Not thread-safe.
 *
 * @param tell is told how a stream stands when that changes.
 */
internal class LocalStreams(
    private val headset: Headset,
    private val scope: CoroutineScope,
    private val tell: suspend (StreamSpec, StreamState) -> Unit,
) {
    private val running = ArrayList<Job>()

    /** Runs [wanted], by ids, with the values named or else the stream's default ones. */
    fun begin(wanted: Map<String, StreamValues>): Map<String, StreamState> = wanted.mapValues { (id, values) ->
        val spec = StreamTable.byId(id) ?: return@mapValues StreamState.Refused("this headset knows no stream $id")
        val requested = values.takeIf { StreamValues() != it } ?: spec.defaultValues()
        val answer = headset.negotiate(spec, requested)
        running += scope.launch { run(spec, requested, answer) }
        answer.toState()
    }

    /** Asks again before each run: what was refused may be allowed by then. */
    private suspend fun run(spec: StreamSpec, requested: StreamValues, first: Answer): Nothing {
        var next: Answer? = first
        var answer = first
        StreamSupervisor { tell(spec, it ?: answer.toState()) }.run({
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
