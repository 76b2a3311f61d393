package dev.ml2sensors.stream

import dev.ml2sensors.source.Answer
import dev.ml2sensors.source.StreamValues

/** What became of a stream the receiver asked for. */
public sealed interface StreamState {
    /** Runs with [values]; [adjusted] says why they are not those asked for, null when they are. */
    public data class Accepted(
        val values: StreamValues,
        val adjusted: String?,
    ) : StreamState

    /**
     * Does not run.
     *
     * @property reason for people: what was expected and found.
     * @property permission the Android permission to request for it, null when that is not what is missing.
     */
    public data class Refused(
        val reason: String,
        val permission: String? = null,
    ) : StreamState

    /**
     * Was accepted and does not run now: its source failed or ended. It is opened again until it runs.
     *
     * @property reason for people: what happened.
     * @property permission the Android permission to request for it, null when that is not what is missing.
     */
    public data class Waiting(
        val reason: String,
        val permission: String? = null,
    ) : StreamState

    /** Ran until its source failed for good, for this [reason]; only recordings do. */
    public data class Failed(
        val reason: String,
    ) : StreamState
}

internal fun Answer.toState(): StreamState =
    when (this) {
        is Answer.Applied -> StreamState.Accepted(values, adjusted = null)
        is Answer.Adjusted -> StreamState.Accepted(values, reason)
        is Answer.Refused -> StreamState.Refused(reason, permission)
    }
