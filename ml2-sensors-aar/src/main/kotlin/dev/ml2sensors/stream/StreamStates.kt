package dev.ml2sensors.stream

import dev.ml2sensors.source.Answer
import dev.ml2sensors.source.Headset
import dev.ml2sensors.source.acceptedValues
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.wire.Status
import kotlinx.coroutines.channels.Channel
import kotlinx.coroutines.flow.MutableStateFlow
import kotlinx.coroutines.flow.StateFlow

/** The state of each requested stream: as it was setAnswers, unless it has stopped. Changed under one lock. */
internal class StreamStates(private val headset: Headset) {
    private val mutableFlow = MutableStateFlow<Map<String, StreamState>>(emptyMap())
    private var answered = emptyMap<String, StreamState>()
    private val stopped = HashMap<String, StreamState>()

    val flow: StateFlow<Map<String, StreamState>> get() = mutableFlow

    /** Receives an element when [toBodies] may have changed. */
    val changes: Channel<Unit> = Channel(Channel.CONFLATED)

    /** The ids of streams that were refused and would be accepted now. */
    @Volatile
    var available: Set<String> = emptySet()
        set(ids) {
            if (field == ids) return
            field = ids
            changes.trySend(Unit)
        }

    /**
     * Sets the states to [answers]. Streams that are [running] keep theirs, and an accepted stream that waits does so
     * until it delivers.
     */
    fun setAnswers(answers: Map<String, Answer>, running: Set<StreamSpec>) {
        val kept = running.map { it.id }.toSet()
        stopped.entries.removeIf { (id, state) ->
            id !in kept && (state !is StreamState.Waiting || answers[id]?.acceptedValues == null)
        }
        available = emptySet()
        setStates(answers.mapValues { (_, answer) -> answer.toState() })
    }

    fun setStates(states: Map<String, StreamState>) {
        answered = states
        publish()
    }

    /** Returns the state of the stream [id] if it has stopped. */
    fun stopped(id: String): StreamState? = stopped[id]

    /** Sets the stopped [state] of the stream [id]; null means that it runs again. */
    fun setStopped(id: String, state: StreamState?) {
        if (state == null) stopped -= id else stopped[id] = state
        publish()
        changes.trySend(Unit)
    }

    private fun publish() {
        mutableFlow.value = answered + stopped
    }

    /** Returns the states as in STATUS; [completed] returns that of a stream with what else is known of it. */
    fun toBodies(completed: (id: String, Status.Stream) -> Status.Stream): Map<String, Status.Stream> {
        val held = headset.holds
        return mutableFlow.value.mapValues { (id, state) ->
            completed(id, state.toBody(held[id], id in available))
        }
    }
}

private fun StreamState.toBody(held: String?, isAvailable: Boolean): Status.Stream = when (this) {
    is StreamState.Running ->
        if (held == null) Status.Stream.of(Status.Stream.RUNNING) else Status.Stream.of(Status.Stream.WAITING, held)

    is StreamState.Waiting -> Status.Stream.of(Status.Stream.WAITING, reason, permission)

    is StreamState.Refused ->
        Status.Stream.of(if (isAvailable) Status.Stream.AVAILABLE else Status.Stream.REFUSED, reason, permission)

    is StreamState.Failed -> Status.Stream.of(Status.Stream.FAILED, reason)
}
