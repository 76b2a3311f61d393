package dev.ml2sensors.stream

import dev.ml2sensors.table.StreamSpec
import kotlinx.coroutines.Job
import kotlinx.coroutines.joinAll
import kotlinx.coroutines.withTimeoutOrNull
import java.util.concurrent.ConcurrentHashMap
import kotlin.time.Duration.Companion.seconds

/** The streams that were to stop and whose device has not let go of them. Thread-safe. */
internal class StoppingStreams {
    private val stuck = ConcurrentHashMap<StreamSpec, Job>()

    /**
     * Ends [jobs], which are of streams, and returns when all have ended, after [LIMIT] at most. A stream whose device
     * has not let go of it by then begins again when it does.
     */
    suspend fun end(jobs: Map<StreamSpec, Job>) {
        jobs.values.forEach(Job::cancel)
        if (withTimeoutOrNull(LIMIT) { jobs.values.joinAll() } == null) stuck += jobs.filterValues { !it.isCompleted }
    }

    /** Returns when no earlier run of [spec] is left; [waits] is called with the reason if that is not at once. */
    suspend fun awaitEnd(spec: StreamSpec, waits: suspend (StreamState) -> Unit) {
        val before = stuck[spec] ?: return
        if (!before.isCompleted) waits(StreamState.Waiting(REASON))
        before.join()
        stuck.remove(spec, before)
    }

    private companion object {
        /** Longer than a source waits for a device to close. */
        val LIMIT = 4.seconds
        const val REASON =
            "the headset has not let go of this stream since it was to stop; it begins again when the headset does; " +
                "if that lasts, restart the headset"
    }
}
