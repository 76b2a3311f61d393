package dev.ml2sensors.simulator

import dev.ml2sensors.session.ReceiverAddress
import dev.ml2sensors.source.Headset
import dev.ml2sensors.source.Sample
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.stream.Ml2Streamer
import dev.ml2sensors.stream.StreamState
import dev.ml2sensors.stream.StreamerState
import dev.ml2sensors.table.StreamSpec
import kotlinx.coroutines.CompletableDeferred
import kotlinx.coroutines.cancelChildren
import kotlinx.coroutines.coroutineScope
import kotlinx.coroutines.delay
import kotlinx.coroutines.flow.Flow
import kotlinx.coroutines.flow.filterIsInstance
import kotlinx.coroutines.flow.first
import kotlinx.coroutines.flow.onEach
import kotlinx.coroutines.launch
import kotlin.time.Duration

/**
 * Streams [headset] to [receiver] and says what happens, until a recording is over, [duration] has passed since the
 * first sample, or [stop] is completed.
 *
 * @return whether no sensor failed.
 */
internal suspend fun stream(
    headset: Headset,
    receiver: ReceiverAddress,
    duration: Duration?,
    stop: CompletableDeferred<String>,
    say: (String) -> Unit,
): Boolean = coroutineScope {
    val hasBegun = CompletableDeferred<Unit>()
    val streamer = Ml2Streamer(ObservedHeadset(headset, hasBegun), receiver)
    launch { streamer.state.collect { say(it.inWords(receiver)) } }
    launch { streamer.streams.collectChanges(say) }
    launch { stop.complete(streamer.state.filterIsInstance<StreamerState.Ended>().first().reason) }
    if (duration != null) {
        launch {
            hasBegun.await()
            delay(duration)
            stop.complete("$duration are over")
        }
    }
    streamer.start()
    streamer.stop(stop.await())
    coroutineContext.cancelChildren()
    streamer.streams.value.values.none { it is StreamState.Failed }
}

/** The [headset], which completes [hasBegun] with the first sample of any stream. */
private class ObservedHeadset(private val headset: Headset, private val hasBegun: CompletableDeferred<Unit>) :
    Headset by headset {
    override fun samples(stream: StreamSpec, values: StreamValues): Flow<Sample> =
        headset.samples(stream, values).onEach { hasBegun.complete(Unit) }
}

private fun StreamerState.inWords(receiver: ReceiverAddress): String = when (this) {
    is StreamerState.Connecting -> "connecting to $receiver" + reason?.let { ": $it" }.orEmpty()
    is StreamerState.Connected -> "connected to $receiverName at $receiver"
    is StreamerState.Ended -> "ended: $reason"
}

/** Says what became of each stream, whenever that changes. */
private suspend fun Flow<Map<String, StreamState>>.collectChanges(say: (String) -> Unit) {
    var last = emptyMap<String, StreamState>()
    collect { states ->
        for (id in last.keys - states.keys) say("  $id: ended")
        for ((id, state) in states) if (state != last[id]) say("  $id: ${state.inWords()}")
        last = states
    }
}

private fun StreamState.inWords(): String = when (this) {
    is StreamState.Accepted -> values.inWords() + adjusted?.let { " (adjusted: $it)" }.orEmpty()
    is StreamState.Refused -> "refused: $reason"
    is StreamState.Failed -> "failed: $reason"
}

private fun StreamValues.inWords(): String =
    if (width == null) "accepted" else "accepted, ${width}x$height@$rateHz $format"
