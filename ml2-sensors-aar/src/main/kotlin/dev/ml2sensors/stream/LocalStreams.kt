package dev.ml2sensors.stream

import dev.ml2sensors.source.Answer
import dev.ml2sensors.source.Headset
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.source.acceptedValues
import dev.ml2sensors.source.defaultValues
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable
import kotlinx.coroutines.CancellationException
import kotlinx.coroutines.CoroutineScope
import kotlinx.coroutines.Job
import kotlinx.coroutines.cancelAndJoin
import kotlinx.coroutines.launch

/**
 * Streams that run without a receiver, for who reads their frames on the headset itself. Not thread-safe.
 *
 * @param failed is told of a stream whose source has failed.
 */
internal class LocalStreams(
    private val headset: Headset,
    private val scope: CoroutineScope,
    private val failed: suspend (StreamSpec, Exception) -> Unit,
) {
    private val running = ArrayList<Job>()

    /** Runs [wanted], by ids, with the values named or else the stream's default ones. */
    fun begin(wanted: Map<String, StreamValues>): Map<String, StreamState> = wanted.mapValues { (id, values) ->
        val spec = StreamTable.byId(id)
        val answer = spec?.let { headset.negotiate(it, values.takeIf { StreamValues() != it } ?: it.defaultValues()) }
            ?: Answer.Refused("this headset knows no stream $id")
        answer.acceptedValues?.let { running += scope.launch { run(checkNotNull(spec), it) } }
        answer.toState()
    }

    private suspend fun run(spec: StreamSpec, values: StreamValues) {
        try {
            headset.samples(spec, values).collect {}
        } catch (e: CancellationException) {
            throw e
        } catch (e: Exception) {
            failed(spec, e)
        }
    }

    /** Returns when all have stopped. */
    suspend fun end() {
        running.forEach { it.cancelAndJoin() }
        running.clear()
    }
}
