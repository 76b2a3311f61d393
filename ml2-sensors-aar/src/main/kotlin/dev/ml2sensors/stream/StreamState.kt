package dev.ml2sensors.stream

import dev.ml2sensors.source.Answer
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.wire.printable

/** The state of a stream that the receiver requested. */
public sealed interface StreamState {
    /** The stream runs with [values]; [adjusted] says why they differ from the requested ones, null if they do not. */
    public data class Running(
        val values: StreamValues,
        val adjusted: String?,
    ) : StreamState

    /**
     * The stream does not run.
     *
     * @property reason for people: what was expected and found.
     * @property permission the Android permission to request for it, null if that is not what is missing.
     */
    public data class Refused(
        val reason: String,
        val permission: String? = null,
    ) : StreamState

    /**
     * The stream ran, or is to run, and does not now, because its source failed or ended. It is opened again until it
     * runs.
     *
     * @property reason for people: what happened.
     * @property permission the Android permission to request for it, null if that is not what is missing.
     */
    public data class Waiting(
        val reason: String,
        val permission: String? = null,
    ) : StreamState

    /** The stream's source failed permanently, for this [reason]; only recordings do. */
    public data class Failed(
        val reason: String,
    ) : StreamState
}

internal fun Answer.toState(): StreamState =
    when (this) {
        is Answer.Applied -> StreamState.Running(values, adjusted = null)
        is Answer.Adjusted -> StreamState.Running(values, reason)
        is Answer.Refused -> StreamState.Refused(printable(reason), permission)
    }
